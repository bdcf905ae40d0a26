// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "morgagni/core/result.h"

namespace mor {

/// A pinhole camera with the lens distortion of Brown and Conrady, as OpenCV writes it.
/// Camera frame: x right, y down, z forward, mm. Pixel (0, 0) is the centre of the first pixel.
struct PinholeCamera {
  int width_px = 0;
  int height_px = 0;
  double focal_x_px = 0.0;
  double focal_y_px = 0.0;
  double center_x_px = 0.0;
  double center_y_px = 0.0;
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3.

  bool operator==(const PinholeCamera&) const = default;

  /// @errors kInvalidArgument: a size outside 1..16384, a focal length or centre that is not finite
  ///         or not positive.
  [[nodiscard]] Result<void> check() const;

  [[nodiscard]] bool has_distortion() const;

  /// Where a point of the camera frame appears, in px (paper, equation (3), with distortion). None
  /// behind the camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;

  /// (x/z, y/z) of the ray that a pixel sees, distortion removed by fixed-point iteration.
  [[nodiscard]] Eigen::Vector2d ray(const Eigen::Vector2d& pixel) const;

  /// The camera that a picture scaled by `factor` (0.5: half as wide) has.
  [[nodiscard]] PinholeCamera scaled(double factor) const;
};

}  // namespace mor
