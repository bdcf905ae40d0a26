// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

enum class StillStyle : std::uint8_t {
  kPlain,     ///< The picture and nothing else.
  kBurnedIn,  ///< Scale, compass and words in the picture.
  kBeside,    ///< The picture as it is; scale, compass and words below it.
};

/// "plain", "burned-in", "beside".
[[nodiscard]] std::string_view to_string(StillStyle style);
[[nodiscard]] std::optional<StillStyle> parse_still_style(std::string_view name);

/// A finding in the picture.
struct StillMark {
  std::string id;
  std::string label;  ///< Of a measurement: its length. May be empty.
  std::vector<Eigen::Vector2d> points_px;
  std::vector<Eigen::Vector2d> line_px;
  bool is_dim = false;
};

/// What a still says beside its picture.
struct StillWords {
  std::string case_name;
  std::string taken_at;  ///< "2026-11-26T16:20:05Z".
  std::string state;     ///< "tracking".
  std::optional<double> bound_mm;
  std::string made_by;                              ///< "Morgagni 0.1.0, frame 1234".
  PinholeCamera camera;                             ///< Of the picture.
  std::optional<Eigen::Isometry3d> camera_from_ct;  ///< None: no compass.
  std::optional<double> scale_depth_mm;             ///< Where the scale bar holds. None: no bar.
  std::string scale_place;  ///< In words: "on the skin in the middle of the hole".
  std::vector<StillMark> marks;
};

/// The scale bar of a picture: its length on the body, and in the picture.
struct ScaleBar {
  double length_mm = 0.0;
  double length_px = 0.0;
};
/// The longest of 1, 2, 5, 10, ... mm that takes a quarter of the picture's width at most.
[[nodiscard]] ScaleBar scale_bar(const PinholeCamera& camera, double depth_mm);

/// A letter of the compass: H head, F feet, L left, R right, A front, P back of the body.
struct CompassLetter {
  char letter = 'H';
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< In the picture, y down; 0..1 long.
  double towards_viewer = 0.0;                          ///< 1: it points at who looks.
};
/// All six, by `towards_viewer` rising.
[[nodiscard]] std::vector<CompassLetter> compass(const Eigen::Isometry3d& camera_from_ct);

/// A picture to take away. A small picture is drawn larger by a whole factor, each pixel as a
/// square of pixels: nothing is interpolated. The plain style is the picture itself.
/// @errors kInvalidArgument: an empty picture, or one of another size than the camera's.
/// @threads Reentrant.
[[nodiscard]] Result<Image<Rgb8>> draw_still(ImageView<const Rgba8> picture,
                                             const StillWords& words,
                                             StillStyle style);

}  // namespace mor
