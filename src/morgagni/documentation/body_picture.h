// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>

#include "morgagni/core/image.h"
#include "morgagni/documentation/export_model.h"

namespace mor {

enum class BodyView : std::uint8_t { kAnterior, kPosterior, kLeft, kRight, kHead, kFeet };

[[nodiscard]] std::string_view to_string(BodyView view);  ///< "anterior", ...

/// A picture of the skin without perspective, so that one scale holds in all of it.
struct BodyPicture {
  Image<Rgb8> picture;  ///< White beside the body.
  Image<float> depth_mm;
  double mm_per_px = 1.0;
  Eigen::Matrix3d view_from_ct = Eigen::Matrix3d::Identity();  ///< x right, y down, z away.
  Eigen::Vector3d middle_ct_mm = Eigen::Vector3d::Zero();      ///< Shown in the middle.
  /// Which way of the body is left, right, up and down in the picture: "R", "L", "H", "F", "A",
  /// "P".
  std::array<std::string_view, 4> letters;

  [[nodiscard]] Eigen::Vector2d place_px(const Eigen::Vector3d& ct_mm) const;
  /// Whether the skin does not hide a place (with a few millimetres' allowance).
  [[nodiscard]] bool is_visible(const Eigen::Vector3d& ct_mm) const;
};

/// Drawn on the CPU, lit from the viewer, each pixel the mean of four samples. Any thread.
/// @param width_px, height_px  1..4096; the body fills the tighter side. Pictures from the four
/// sides of one size have one scale.
[[nodiscard]] BodyPicture draw_body(const ExportModel& model,
                                    BodyView view,
                                    int width_px,
                                    int height_px);

}  // namespace mor
