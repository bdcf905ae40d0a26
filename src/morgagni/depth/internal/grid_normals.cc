// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/depth/internal/grid_normals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace mor::internal {
namespace {

/// Half the window at full resolution: about 8 mm of skin at 0.8 m, where the slope of a Kinect's
/// noise has fallen to some 3 degrees.
constexpr double kHalfWindowPx = 5.0;
constexpr int kMinRadius = 2;
/// Finer grids than this are fitted in cells of 2x2 pixels.
constexpr double kCellsBelowFactor = 1.75;
/// Fewer pixels than this fix no plane worth having.
constexpr int kMinPlanePixels = 6;

/// target[i] += weight * source[i]
void add_scaled(float* __restrict target,
                const float* __restrict source,
                float weight,
                std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) target[i] += weight * source[i];
}

}  // namespace

GridNormals::GridNormals(const PinholeCamera& camera, double factor, int width, int height)
    : grid_width_(width),
      grid_height_(height),
      cell_shift_(factor < kCellsBelowFactor ? 1 : 0),
      width_((width + cell_shift_) >> cell_shift_),
      height_((height + cell_shift_) >> cell_shift_) {
  const double cell_px = factor * (1 << cell_shift_);
  radius_ = std::max(kMinRadius, static_cast<int>(std::lround(kHalfWindowPx / cell_px)));
  const double center_px = 0.5 * (cell_px - factor);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Eigen::Vector2d pixel(x * cell_px + center_px, y * cell_px + center_px);
      const Eigen::Vector2d half_x(cell_px / 2.0, 0.0);
      const Eigen::Vector2d half_y(0.0, cell_px / 2.0);
      const double ray_step_x = (camera.ray(pixel + half_x) - camera.ray(pixel - half_x)).x();
      const double ray_step_y = (camera.ray(pixel + half_y) - camera.ray(pixel - half_y)).y();
      const Eigen::Vector2d ray = camera.ray(pixel);
      ray_x_.push_back(static_cast<float>(ray.x()));
      ray_y_.push_back(static_cast<float>(ray.y()));
      steps_per_ray_x_.push_back(static_cast<float>(1.0 / ray_step_x));
      steps_per_ray_y_.push_back(static_cast<float>(1.0 / ray_step_y));
    }
  }
  const std::size_t count = ray_x_.size();
  for (auto* values : {&inside_, &inverse_, &row_count_, &row_sum_, &row_moment_}) {
    values->resize(count);
  }
  normals_.resize(count);
}

void GridNormals::fit(const std::vector<float>& z_mm, const std::vector<std::uint8_t>& mask) {
  fill_cells(z_mm, mask);
  const int first = std::max(0, first_row_ - radius_);
  const int end = std::min(height_, end_row_ + radius_);
  for (int y = first; y < end; ++y) sum_row(y);
  for (int y = first_row_; y < end_row_; ++y) {
    sum_columns(y);
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    for (int x = 0; x < width_; ++x) {
      const std::size_t i = row + static_cast<std::size_t>(x);
      if (inside_[i] != 0.0F) normals_[i] = normal(x, y);
    }
  }
}

void GridNormals::fill_cells(const std::vector<float>& z_mm,
                             const std::vector<std::uint8_t>& mask) {
  std::fill(inside_.begin(), inside_.end(), 0.0F);
  std::fill(inverse_.begin(), inverse_.end(), 0.0F);
  std::size_t pixel = 0;
  for (int y = 0; y < grid_height_; ++y) {
    const std::size_t row =
        static_cast<std::size_t>(y >> cell_shift_) * static_cast<std::size_t>(width_);
    for (int x = 0; x < grid_width_; ++x, ++pixel) {
      if (mask[pixel] == 0) continue;
      const std::size_t cell = row + static_cast<std::size_t>(x >> cell_shift_);
      inside_[cell] += 1.0F;
      inverse_[cell] += 1.0F / z_mm[pixel];
    }
  }
  first_row_ = height_;
  end_row_ = 0;
  for (int y = 0; y < height_; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    float row_count = 0.0F;
    for (std::size_t i = row; i < row + static_cast<std::size_t>(width_); ++i) {
      row_count += inside_[i];
      inverse_[i] /= std::max(1.0F, inside_[i]);
      inside_[i] = std::min(1.0F, inside_[i]);
    }
    if (row_count == 0.0F) continue;
    first_row_ = std::min(first_row_, y);
    end_row_ = y + 1;
  }
}

// Windows are cut off at the picture's border, which makes them partial ones: their count is low.
void GridNormals::sum_row(int y) {
  const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  for (auto* sums : {&row_count_, &row_sum_, &row_moment_}) {
    std::fill_n(sums->begin() + static_cast<std::ptrdiff_t>(row), width_, 0.0F);
  }
  for (int k = -radius_; k <= radius_; ++k) {
    if (std::abs(k) >= width_) continue;
    const auto count = static_cast<std::size_t>(width_ - std::abs(k));
    const std::size_t target = row + static_cast<std::size_t>(std::max(0, -k));
    const std::size_t source = row + static_cast<std::size_t>(std::max(0, k));
    add_scaled(row_count_.data() + target, inside_.data() + source, 1.0F, count);
    add_scaled(row_sum_.data() + target, inverse_.data() + source, 1.0F, count);
    add_scaled(row_moment_.data() + target, inverse_.data() + source, static_cast<float>(k), count);
  }
}

void GridNormals::sum_columns(int y) {
  const auto width = static_cast<std::size_t>(width_);
  for (auto* sums : {&count_, &sum_, &moment_x_, &moment_y_}) sums->assign(width, 0.0F);
  for (int l = -radius_; l <= radius_; ++l) {
    if (y + l < 0 || y + l >= height_) continue;
    const std::size_t source = static_cast<std::size_t>(y + l) * width;
    add_scaled(count_.data(), row_count_.data() + source, 1.0F, width);
    add_scaled(sum_.data(), row_sum_.data() + source, 1.0F, width);
    add_scaled(moment_x_.data(), row_moment_.data() + source, 1.0F, width);
    add_scaled(moment_y_.data(), row_sum_.data() + source, static_cast<float>(l), width);
  }
}

GridNormals::Plane GridNormals::partial_window_plane(int x, int y) const {
  Eigen::Matrix3f normal_matrix = Eigen::Matrix3f::Zero();
  Eigen::Vector3f right_side = Eigen::Vector3f::Zero();
  const int y_end = std::min(height_, y + radius_ + 1);
  const int x_end = std::min(width_, x + radius_ + 1);
  for (int v = std::max(0, y - radius_); v < y_end; ++v) {
    for (int u = std::max(0, x - radius_); u < x_end; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                            static_cast<std::size_t>(u);
      const Eigen::Vector3f basis(1.0F, static_cast<float>(u - x), static_cast<float>(v - y));
      normal_matrix += inside_[i] * basis * basis.transpose();
      right_side += inverse_[i] * basis;
    }
  }
  const std::size_t center =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  const bool enough = normal_matrix(0, 0) >= static_cast<float>(kMinPlanePixels);
  if (!enough || normal_matrix.determinant() < normal_matrix(0, 0)) {
    return {inverse_[center], 0.0F, 0.0F};
  }
  const Eigen::Vector3f plane = normal_matrix.ldlt().solve(right_side);
  return {plane[0], plane[1], plane[2]};
}

Eigen::Vector3f GridNormals::normal(int x, int y) const {
  const auto column = static_cast<std::size_t>(x);
  const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + column;
  const auto side = static_cast<float>(2 * radius_ + 1);
  const bool full = count_[column] == side * side;
  Plane plane;
  if (full) {
    // The sum of k^2 over a full window; that of k l and those of k and l vanish.
    const float spread =
        side * static_cast<float>(radius_ * (radius_ + 1) * (2 * radius_ + 1)) / 3.0F;
    plane = {sum_[column] / (side * side), moment_x_[column] / spread, moment_y_[column] / spread};
  } else {
    plane = partial_window_plane(x, y);
  }
  if (plane.slope_x == 0.0F && plane.slope_y == 0.0F && !full) {
    return -Eigen::Vector3f(ray_x_[i], ray_y_[i], 1.0F).normalized();
  }
  // On the plane n . p = d holds q = 1/z = (n / d) . (x/z, y/z, 1): the coefficients are n / d.
  const float a = plane.slope_x * steps_per_ray_x_[i];
  const float b = plane.slope_y * steps_per_ray_y_[i];
  return -Eigen::Vector3f(a, b, plane.mean - a * ray_x_[i] - b * ray_y_[i]).normalized();
}

}  // namespace mor::internal
