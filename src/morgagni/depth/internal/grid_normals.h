// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// Surface normals of a depth image, from planes fitted to a window around each pixel.
///
/// A plane seen by a pinhole has an inverse depth that is linear over the picture, and a Kinect's
/// noise and steps are even in inverse depth. So 1/z is fitted by least squares over a window of
/// (2 radius + 1)^2 pixels, of which only those inside the body count.
class GridNormals {
 public:
  /// @param factor  Down-sampling of the grid.
  GridNormals(const PinholeCamera& camera, double factor, int grid_width, int grid_height);

  /// @param z_mm, mask  Of the grid; z is read where the mask is 1.
  /// @param ray_x, ray_y  x/z and y/z of the pixels.
  /// Call `at` afterwards, for pixels inside the mask.
  void fit(const std::vector<float>& z_mm, const std::vector<std::uint8_t>& mask);

  /// The unit normal at a pixel, towards the camera. Where the window holds too few pixels for a
  /// plane, the direction to the camera.
  [[nodiscard]] Eigen::Vector3f at(int x, int y, float ray_x, float ray_y) const;

 private:
  /// The plane q = mean + slope_x k + slope_y l of inverse depths, k and l in grid steps.
  struct Plane {
    float mean = 0.0F;
    float slope_x = 0.0F;
    float slope_y = 0.0F;
  };

  void sum_rows();
  void sum_columns();
  [[nodiscard]] Plane full_window_plane(std::size_t i) const;
  [[nodiscard]] Plane partial_window_plane(int x, int y) const;

  int width_;
  int height_;
  int radius_;
  std::vector<float> steps_per_ray_x_;  ///< Grid steps per unit of x/z, one a pixel.
  std::vector<float> steps_per_ray_y_;
  std::vector<float> inside_;   ///< 1 inside the mask, 0 outside.
  std::vector<float> inverse_;  ///< 1/z inside the mask, 0 outside.
  std::vector<float> row_count_, row_sum_, row_moment_;
  std::vector<float> count_, sum_, moment_x_, moment_y_;
};

}  // namespace mor::internal
