// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include <Eigen/Geometry>

#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/render/internal/pixel_box.h"

namespace mor::internal {

/// What shaders/surface.vert.glsl needs to put the CT on a part of a camera's picture.
struct CameraUniforms {
  Eigen::Matrix4f camera_from_ct;
  std::array<float, 2> focal_ndc{};
  std::array<float, 2> center_ndc{};
  std::array<float, 5> distortion{};
  float max_radius_sq = 0.0F;
  std::array<float, 2> depth_clip{};
  std::array<float, 2> depth_range_mm{};
  std::array<float, 4> cut_plane = {0.0F, 0.0F, 0.0F, 1.0F};  ///< Drawn where it is >= 0: all.
};

/// @param bounds  Of all that is drawn, frame ct: the near and far planes lie around it.
/// @param box  The part of the picture that fills the target; its first row becomes row 0.
/// @return None where all of `bounds` is behind the camera.
[[nodiscard]] std::optional<CameraUniforms> camera_uniforms(const PinholeCamera& camera,
                                                            const Eigen::Isometry3d& camera_from_ct,
                                                            const Eigen::AlignedBox3f& bounds,
                                                            const PixelBox& box);

}  // namespace mor::internal
