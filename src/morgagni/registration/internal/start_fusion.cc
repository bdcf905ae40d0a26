// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_fusion.h"

#include <cmath>

#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

/// Readings farther apart than this share of their distance lie on two surfaces.
constexpr float kSurfaceReach = 0.012F;
/// Two pictures differ by no more at one place: their noise, and the motion's error.
constexpr float kReachMm = 1.0F;
constexpr float kReachNoises = 3.0F;

/// The depth at a place between four pixels that lie on one surface; 0 where they do not.
float depth_at(const Image<float>& z_mm, float x, float y, float expected_mm) {
  const int left = static_cast<int>(std::floor(x));
  const int top = static_cast<int>(std::floor(y));
  if (left < 0 || top < 0 || left + 1 >= z_mm.width() || top + 1 >= z_mm.height()) return 0.0F;
  const float u = x - static_cast<float>(left);
  const float v = y - static_cast<float>(top);
  float sum = 0.0F;
  for (int k = 0; k < 4; ++k) {
    const float z = z_mm(left + k % 2, top + k / 2);
    if (std::abs(z - expected_mm) > kSurfaceReach * expected_mm) return 0.0F;
    sum += (k % 2 == 0 ? 1.0F - u : u) * (k / 2 == 0 ? 1.0F - v : v) * z;
  }
  return sum;
}

/// Adds to each reading's sum what the other picture measured there.
void add(const StartPicture& picture,
         const OtherPicture& other,
         Image<float>& sum_mm,
         Image<float>& count) {
  const Eigen::Isometry3f motion = other.other_from_this.cast<float>();
  const PinholeCamera& camera = other.picture->camera;
  const auto fx = static_cast<float>(camera.focal_x_px);
  const auto fy = static_cast<float>(camera.focal_y_px);
  const auto cx = static_cast<float>(camera.center_x_px);
  const auto cy = static_cast<float>(camera.center_y_px);
  for (int y = 0; y < picture.z_mm.height(); ++y) {
    for (int x = 0; x < picture.z_mm.width(); ++x) {
      const float z = picture.even_mm(x, y);
      if (z <= 0.0F) continue;
      const Eigen::Vector3f p = motion * picture.point_at(x, y, z);
      if (p.z() < 1.0F) continue;
      const float there =
          depth_at(other.picture->z_mm, fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy, p.z());
      const float off_mm = there - p.z();
      if (std::abs(off_mm) > kReachMm + kReachNoises * axial_noise_mm(p.z())) continue;
      sum_mm(x, y) += z + off_mm;
      count(x, y) += 1.0F;
    }
  }
}

}  // namespace

StartPicture fused(const StartPicture& picture, const std::vector<OtherPicture>& others) {
  StartPicture all = picture;
  Image<float> count(picture.z_mm.width(), picture.z_mm.height(), 1.0F);
  for (const auto& other : others) add(picture, other, all.z_mm, count);
  for (std::size_t i = 0; i < all.z_mm.size(); ++i) all.z_mm.data()[i] /= count.data()[i];
  all.even_mm = evened(all.z_mm);
  all.noise_share = 1.0F / std::sqrt(1.0F + static_cast<float>(others.size()));
  return all;
}

}  // namespace mor::internal
