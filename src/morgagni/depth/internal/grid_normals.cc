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
    : width_(width),
      height_(height),
      radius_(std::max(kMinRadius, static_cast<int>(std::lround(kHalfWindowPx / factor)))) {
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d pixel(x * factor, y * factor);
      const Eigen::Vector2d half_x(factor / 2.0, 0.0);
      const Eigen::Vector2d half_y(0.0, factor / 2.0);
      const double ray_step_x = (camera.ray(pixel + half_x) - camera.ray(pixel - half_x)).x();
      const double ray_step_y = (camera.ray(pixel + half_y) - camera.ray(pixel - half_y)).y();
      steps_per_ray_x_.push_back(static_cast<float>(1.0 / ray_step_x));
      steps_per_ray_y_.push_back(static_cast<float>(1.0 / ray_step_y));
    }
  }
}

void GridNormals::fit(const std::vector<float>& z_mm, const std::vector<std::uint8_t>& mask) {
  inside_.resize(z_mm.size());
  inverse_.resize(z_mm.size());
  for (std::size_t i = 0; i < z_mm.size(); ++i) {
    inside_[i] = mask[i] != 0 ? 1.0F : 0.0F;
    inverse_[i] = mask[i] != 0 ? 1.0F / z_mm[i] : 0.0F;
  }
  sum_rows();
  sum_columns();
}

// Windows are cut off at the picture's border, which makes them partial ones: their count is low.
void GridNormals::sum_rows() {
  row_count_.assign(inside_.size(), 0.0F);
  row_sum_.assign(inside_.size(), 0.0F);
  row_moment_.assign(inside_.size(), 0.0F);
  for (int y = 0; y < height_; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    for (int k = -radius_; k <= radius_; ++k) {
      if (std::abs(k) >= width_) continue;
      const auto count = static_cast<std::size_t>(width_ - std::abs(k));
      const std::size_t target = row + static_cast<std::size_t>(std::max(0, -k));
      const std::size_t source = row + static_cast<std::size_t>(std::max(0, k));
      add_scaled(row_count_.data() + target, inside_.data() + source, 1.0F, count);
      add_scaled(row_sum_.data() + target, inverse_.data() + source, 1.0F, count);
      add_scaled(
          row_moment_.data() + target, inverse_.data() + source, static_cast<float>(k), count);
    }
  }
}

void GridNormals::sum_columns() {
  for (auto* sums : {&count_, &sum_, &moment_x_, &moment_y_}) sums->assign(inside_.size(), 0.0F);
  const auto width = static_cast<std::size_t>(width_);
  for (int y = 0; y < height_; ++y) {
    const std::size_t target = static_cast<std::size_t>(y) * width;
    for (int l = -radius_; l <= radius_; ++l) {
      if (y + l < 0 || y + l >= height_) continue;
      const std::size_t source = static_cast<std::size_t>(y + l) * width;
      add_scaled(count_.data() + target, row_count_.data() + source, 1.0F, width);
      add_scaled(sum_.data() + target, row_sum_.data() + source, 1.0F, width);
      add_scaled(moment_x_.data() + target, row_moment_.data() + source, 1.0F, width);
      add_scaled(moment_y_.data() + target, row_sum_.data() + source, static_cast<float>(l), width);
    }
  }
}

GridNormals::Plane GridNormals::full_window_plane(std::size_t i) const {
  const auto side = static_cast<float>(2 * radius_ + 1);
  // The sum of k^2 over the window; that of k l and those of k and l vanish.
  const float spread =
      side * static_cast<float>(radius_ * (radius_ + 1) * (2 * radius_ + 1)) / 3.0F;
  return {sum_[i] / (side * side), moment_x_[i] / spread, moment_y_[i] / spread};
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

Eigen::Vector3f GridNormals::at(int x, int y, float ray_x, float ray_y) const {
  const std::size_t i =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  const int side = 2 * radius_ + 1;
  const bool full = count_[i] == static_cast<float>(side * side);
  const Plane plane = full ? full_window_plane(i) : partial_window_plane(x, y);
  if (plane.slope_x == 0.0F && plane.slope_y == 0.0F && !full) {
    return -Eigen::Vector3f(ray_x, ray_y, 1.0F).normalized();
  }
  // On the plane n . p = d holds q = 1/z = (n / d) . (x/z, y/z, 1): the coefficients are n / d.
  const float a = plane.slope_x * steps_per_ray_x_[i];
  const float b = plane.slope_y * steps_per_ray_y_[i];
  return -Eigen::Vector3f(a, b, plane.mean - a * ray_x - b * ray_y).normalized();
}

}  // namespace mor::internal
