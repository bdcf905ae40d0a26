// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace mor::internal {
namespace {

constexpr int kSmallWidthPx = 320;
constexpr int kMaxBlock = 6;
/// Readings of one block farther apart than this share of their distance lie on two surfaces.
constexpr float kBlockReach = 0.015F;
constexpr float kSurfaceReach = 0.012F;  ///< Likewise, of neighbours within 2 px.
constexpr int kMinNormalPoints = 6;
/// A reading belongs to a surface if so many of the eight around it are as near to it as this.
constexpr int kLeastNeighbours = 4;
constexpr float kNeighbourReach = 0.03F;

/// Drops readings that belong to no surface: at outlines a sensor's stray sideways.
void drop_strays(Image<float>& z_mm) {
  const Image<float> all = z_mm;
  for (int y = 0; y < all.height(); ++y) {
    for (int x = 0; x < all.width(); ++x) {
      const float z = all(x, y);
      if (z <= 0.0F) continue;
      int count = -1;  // Itself is one of the nine.
      for (int v = std::max(0, y - 1); v <= std::min(all.height() - 1, y + 1); ++v) {
        for (int u = std::max(0, x - 1); u <= std::min(all.width() - 1, x + 1); ++u) {
          if (std::abs(all(u, v) - z) <= kNeighbourReach * z) ++count;
        }
      }
      if (count < kLeastNeighbours) z_mm(x, y) = 0.0F;
    }
  }
}

}  // namespace

std::optional<Eigen::Vector3f> StartPicture::normal(int x, int y, float radius_mm) const {
  const float center_z = z_mm(x, y);
  if (center_z <= 0.0F) return std::nullopt;
  const int reach_px =
      std::clamp(static_cast<int>(std::lround(radius_mm * camera.focal_x_px / center_z)), 2, 10);
  const int step = reach_px > 4 ? 2 : 1;
  // A plane has an inverse depth that is linear over the picture, and a Kinect's noise is even
  // there: 1/z = a + b k + c l by least squares.
  const float reach_mm =
      1.5F * std::max(radius_mm, center_z * static_cast<float>(reach_px / camera.focal_x_px));
  Eigen::Matrix3f sums = Eigen::Matrix3f::Zero();
  Eigen::Vector3f right = Eigen::Vector3f::Zero();
  int count = 0;
  for (int l = -reach_px; l <= reach_px; l += step) {
    for (int k = -reach_px; k <= reach_px; k += step) {
      if (!z_mm.view().contains(x + k, y + l)) continue;
      const float z = z_mm(x + k, y + l);
      if (z <= 0.0F || std::abs(z - center_z) > reach_mm) continue;
      const Eigen::Vector3f row(1.0F, static_cast<float>(k), static_cast<float>(l));
      sums += row * row.transpose();
      right += (center_z / z - 1.0F) * row;
      ++count;
    }
  }
  if (count < kMinNormalPoints) return std::nullopt;
  if (sums.determinant() < 1e-3F * sums.trace()) return std::nullopt;
  const Eigen::Vector3f fit = sums.ldlt().solve(right);
  // 1/z = A x/z + B y/z + C  <=>  A x + B y + C z = 1: the normal is (A, B, C).
  const auto fx = static_cast<float>(camera.focal_x_px);
  const auto fy = static_cast<float>(camera.focal_y_px);
  const float ray_x = (static_cast<float>(x) - static_cast<float>(camera.center_x_px)) / fx;
  const float ray_y = (static_cast<float>(y) - static_cast<float>(camera.center_y_px)) / fy;
  const float a = fx * fit[1];
  const float b = fy * fit[2];
  const Eigen::Vector3f normal(a, b, 1.0F + fit[0] - a * ray_x - b * ray_y);
  const float norm = normal.norm();
  if (!(norm > 1e-6F) || !std::isfinite(norm)) return std::nullopt;
  return -normal / norm;
}

Image<float> evened(const Image<float>& z_mm) {
  constexpr int kReach = 2;
  Image<float> even_mm = z_mm;
  for (int y = kReach; y + kReach < z_mm.height(); ++y) {
    for (int x = kReach; x + kReach < z_mm.width(); ++x) {
      const float z = z_mm(x, y);
      if (z <= 0.0F) continue;
      float sum = z;
      float count = 1.0F;
      for (int v = 0; v <= kReach; ++v) {
        for (int u = v == 0 ? 1 : -kReach; u <= kReach; ++u) {
          const float one = z_mm(x + u, y + v);
          const float other = z_mm(x - u, y - v);
          if (std::abs(one - z) > kSurfaceReach * z || std::abs(other - z) > kSurfaceReach * z) {
            continue;
          }
          sum += one + other;
          count += 2.0F;
        }
      }
      even_mm(x, y) = sum / count;
    }
  }
  return even_mm;
}

StartPictureMaker::StartPictureMaker(const PinholeCamera& depth_camera) {
  side_ = std::clamp(
      static_cast<int>(std::lround(depth_camera.width_px / static_cast<double>(kSmallWidthPx))),
      1,
      kMaxBlock);
  small_camera_ = depth_camera.scaled(1.0 / side_);
  small_camera_.width_px = std::max(1, depth_camera.width_px / side_);
  small_camera_.height_px = std::max(1, depth_camera.height_px / side_);
  small_camera_.distortion = {};
  blocks_.resize(static_cast<std::size_t>(small_camera_.width_px) *
                 static_cast<std::size_t>(small_camera_.height_px));
  for (int y = 0; y < small_camera_.height_px; ++y) {
    for (int x = 0; x < small_camera_.width_px; ++x) {
      const Eigen::Vector2d ray = small_camera_.ray({x, y});
      const auto pixel = depth_camera.project({ray.x(), ray.y(), 1.0});
      if (!pixel) continue;
      const int left = static_cast<int>(std::lround(pixel->x() - 0.5 * (side_ - 1)));
      const int top = static_cast<int>(std::lround(pixel->y() - 0.5 * (side_ - 1)));
      if (left < 0 || top < 0 || left + side_ > depth_camera.width_px ||
          top + side_ > depth_camera.height_px) {
        continue;
      }
      blocks_[static_cast<std::size_t>(y) * static_cast<std::size_t>(small_camera_.width_px) +
              static_cast<std::size_t>(x)] = {left, top};
    }
  }
}

StartPicture StartPictureMaker::make(ImageView<const std::uint16_t> depth_mm, float max_mm) const {
  StartPicture picture{
      small_camera_, Image<float>(small_camera_.width_px, small_camera_.height_px), {}};
  std::array<float, kMaxBlock * kMaxBlock> readings{};
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    if (block.x < 0) continue;
    std::size_t count = 0;
    for (int y = block.y; y < block.y + side_; ++y) {
      for (int x = block.x; x < block.x + side_; ++x) {
        const auto z = static_cast<float>(depth_mm(x, y));
        if (z > 0.0F && z <= max_mm) readings[count++] = z;
      }
    }
    if (count == 0) continue;
    // The mean of those near the median: a block on an outline belongs to one side.
    const auto middle = readings.begin() + static_cast<std::ptrdiff_t>((count - 1) / 2);
    const auto end = readings.begin() + static_cast<std::ptrdiff_t>(count);
    std::nth_element(readings.begin(), middle, end);
    const float median = *middle;
    float sum = 0.0F;
    float num = 0.0F;
    for (auto z = readings.begin(); z != end; ++z) {
      if (std::abs(*z - median) > kBlockReach * median) continue;
      sum += *z;
      num += 1.0F;
    }
    picture.z_mm.data()[i] = sum / num;
  }
  drop_strays(picture.z_mm);
  picture.even_mm = evened(picture.z_mm);
  return picture;
}

}  // namespace mor::internal
