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
/// which only the pixels inside the body count. At little down-sampling, where windows hold many
/// pixels, cells of 2x2 pixels are fitted instead: a quarter of the work at the same noise.
class GridNormals {
 public:
  /// @param factor  Down-sampling of the grid.
  GridNormals(const PinholeCamera& camera, double factor, int grid_width, int grid_height);

  /// @param z_mm, mask  Of the grid; z is read where the mask is 1.
  /// Call `at` afterwards, for pixels inside the mask.
  void fit(const std::vector<float>& z_mm, const std::vector<std::uint8_t>& mask);

  /// The unit normal at a pixel, towards the camera. Where the window holds too few pixels for a
  /// plane, the direction to the camera.
  [[nodiscard]] const Eigen::Vector3f& at(int x, int y) const {
    return normals_[static_cast<std::size_t>(y >> cell_shift_) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x >> cell_shift_)];
  }

 private:
  /// The plane q = mean + slope_x k + slope_y l of inverse depths, k and l in cells.
  struct Plane {
    float mean = 0.0F;
    float slope_x = 0.0F;
    float slope_y = 0.0F;
  };

  void fill_cells(const std::vector<float>& z_mm, const std::vector<std::uint8_t>& mask);
  void sum_row(int y);
  void sum_columns(int y);
  [[nodiscard]] Plane partial_window_plane(int x, int y) const;
  [[nodiscard]] Eigen::Vector3f normal(int x, int y) const;

  int grid_width_;
  int grid_height_;
  int cell_shift_;  ///< Cells are 1 << cell_shift_ pixels wide and high.
  int width_;       ///< In cells, as everything below.
  int height_;
  int radius_;
  int first_row_ = 0;  ///< Rows of cells that the body covers.
  int end_row_ = 0;
  std::vector<float> ray_x_, ray_y_;    ///< x/z and y/z of a cell's centre.
  std::vector<float> steps_per_ray_x_;  ///< Cells per unit of x/z, one a cell.
  std::vector<float> steps_per_ray_y_;
  std::vector<float> inside_;   ///< 1 where a cell has a pixel inside the mask, 0 elsewhere.
  std::vector<float> inverse_;  ///< Mean of 1/z over those pixels, 0 elsewhere.
  std::vector<float> row_count_, row_sum_, row_moment_;
  std::vector<float> count_, sum_, moment_x_, moment_y_;  ///< Of one row of windows.
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace mor::internal
