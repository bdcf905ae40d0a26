// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/skin_readings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "morgagni/geometry/depth_raster.h"

namespace mor {
namespace {

constexpr int kBlockPx = SkinReading::kBlockPx;
/// Of a block's pixels, so many must be readings on the skin.
constexpr int kLeastReadings = 12;
/// Readings farther than this from where the pose puts the skin are not the skin's.
constexpr float kOnSkinMm = 10.0F;
/// A block over which the skin's depth differs by more lies at an edge.
constexpr float kMostReliefMm = 14.0F;
/// What lies beside the body is read no farther off.
constexpr float kFarthestBesideMm = 1500.0F;
constexpr int kBesideStepPx = 4 * kBlockPx;

/// A Gaussian of kReadingBlurPx, in whole pixels.
constexpr std::array<float, 5> kBlur = {0.030F, 0.236F, 0.468F, 0.236F, 0.030F};

/// Blurs rows or columns; where the neighbours are another surface or none, leaves the pixel.
Image<float> blurred(const Image<float>& z_mm, int step_x, int step_y) {
  Image<float> result(z_mm.width(), z_mm.height(), 0.0F);
  for (int y = 2 * step_y; y < z_mm.height() - 2 * step_y; ++y) {
    for (int x = 2 * step_x; x < z_mm.width() - 2 * step_x; ++x) {
      const float middle = z_mm(x, y);
      if (middle <= 0.0F) continue;
      float sum = 0.0F;
      for (int i = -2; i <= 2; ++i) {
        const float z = z_mm(x + i * step_x, y + i * step_y);
        const bool is_same = std::abs(z - middle) < kMostReliefMm;
        sum += kBlur[static_cast<std::size_t>(i + 2)] * (is_same ? z : middle);
      }
      result(x, y) = sum;
    }
  }
  return result;
}

}  // namespace

Image<float> expected_depth(const TriangleMesh& skin,
                            const PinholeCamera& camera,
                            const Eigen::Isometry3d& ct_from_depth) {
  PinholeCamera straight = camera;
  straight.distortion = {};
  auto drawn = rasterize_depth(skin, straight, ct_from_depth.inverse()).depth_mm;
  drawn = blurred(blurred(drawn, 1, 0), 0, 1);
  if (!camera.has_distortion()) return drawn;
  Image<float> bent(camera.width_px, camera.height_px, 0.0F);
  for (int y = 0; y < bent.height(); ++y) {
    for (int x = 0; x < bent.width(); ++x) {
      const Eigen::Vector2d ray = camera.ray(Eigen::Vector2d(x, y));
      const auto pixel = straight.project(Eigen::Vector3d(ray.x(), ray.y(), 1.0));
      if (!pixel || pixel->x() < 0.0 || pixel->y() < 0.0) continue;
      const int left = static_cast<int>(pixel->x());
      const int top = static_cast<int>(pixel->y());
      if (left + 1 >= drawn.width() || top + 1 >= drawn.height()) continue;
      const auto share_x = static_cast<float>(pixel->x() - left);
      const auto share_y = static_cast<float>(pixel->y() - top);
      const float a = drawn(left, top);
      const float b = drawn(left + 1, top);
      const float c = drawn(left, top + 1);
      const float d = drawn(left + 1, top + 1);
      if (std::min({a, b, c, d}) <= 0.0F) continue;
      bent(x, y) = std::lerp(std::lerp(a, b, share_x), std::lerp(c, d, share_x), share_y);
    }
  }
  return bent;
}

namespace {

/// A block's skin as the drawn picture shows it. None where it is not one patch.
bool is_one_patch(const Image<float>& expected, int left, int top) {
  float nearest = std::numeric_limits<float>::max();
  float farthest = 0.0F;
  for (int y = top; y < top + kBlockPx; ++y) {
    for (int x = left; x < left + kBlockPx; ++x) {
      nearest = std::min(nearest, expected(x, y));
      farthest = std::max(farthest, expected(x, y));
    }
  }
  return nearest > 0.0F && farthest - nearest <= kMostReliefMm;
}

/// The mean of a block's readings that count.
/// @param counts  Of the pixel and its reading in mm.
template <class Counts>
SkinReading read_block(ImageView<const std::uint16_t> depth_mm,
                       const DepthLevels& levels,
                       int left,
                       int top,
                       const Counts& counts) {
  SkinReading reading;
  reading.column = static_cast<std::uint16_t>(left / kBlockPx);
  reading.row = static_cast<std::uint16_t>(top / kBlockPx);
  float count = 0.0F;
  for (int y = 0; y < kBlockPx; ++y) {
    for (int x = 0; x < kBlockPx; ++x) {
      const float z_mm = levels.mm(depth_mm(left + x, top + y));
      if (z_mm <= 0.0F || !counts(left + x, top + y, z_mm)) continue;
      reading.used |= static_cast<std::uint16_t>(1U << (y * kBlockPx + x));
      reading.z_mm += z_mm;
      reading.pixel += Eigen::Vector2f(static_cast<float>(left + x), static_cast<float>(top + y));
      count += 1.0F;
    }
  }
  reading.z_mm /= std::max(1.0F, count);
  reading.pixel /= std::max(1.0F, count);
  return reading;
}

/// Whether no skin is to be seen in a block or the blocks around it.
bool is_beside_skin(const Image<float>& expected, int left, int top) {
  for (int y = top - kBlockPx; y < top + 2 * kBlockPx; ++y) {
    for (int x = left - kBlockPx; x < left + 2 * kBlockPx; ++x) {
      if (expected.view().contains(x, y) && expected(x, y) > 0.0F) return false;
    }
  }
  return true;
}

/// One block of sixteen beside the skin whose readings may be one surface's.
void read_beside(ImageView<const std::uint16_t> depth_mm,
                 const DepthLevels& levels,
                 const Image<float>& expected,
                 std::vector<SkinReading>& beside) {
  for (int top = 0; top + kBlockPx <= expected.height(); top += kBesideStepPx) {
    for (int left = 0; left + kBlockPx <= expected.width(); left += kBesideStepPx) {
      if (!is_beside_skin(expected, left, top)) continue;
      float nearest_mm = kFarthestBesideMm;
      float farthest_mm = 0.0F;
      const auto reading = read_block(depth_mm, levels, left, top, [&](int, int, float z_mm) {
        nearest_mm = std::min(nearest_mm, z_mm);
        farthest_mm = std::max(farthest_mm, z_mm);
        return true;
      });
      const bool is_one_surface =
          farthest_mm < kFarthestBesideMm && farthest_mm - nearest_mm <= kMostReliefMm;
      if (is_one_surface && std::popcount(reading.used) >= kLeastReadings) {
        beside.push_back(reading);
      }
    }
  }
}

}  // namespace

SensedSkin read_skin(const TriangleMesh& skin,
                     const PinholeCamera& camera,
                     ImageView<const std::uint16_t> depth_mm,
                     const DepthLevels& levels,
                     const Eigen::Isometry3d& ct_from_depth) {
  SensedSkin view;
  view.ct_from_depth = ct_from_depth;
  const auto expected = expected_depth(skin, camera, ct_from_depth);
  const auto is_on_skin = [&](int x, int y, float z_mm) {
    return std::abs(z_mm - expected(x, y)) <= kOnSkinMm;
  };
  for (int top = 0; top + kBlockPx <= expected.height(); top += kBlockPx) {
    for (int left = 0; left + kBlockPx <= expected.width(); left += kBlockPx) {
      if (!is_one_patch(expected, left, top)) continue;
      const auto reading = read_block(depth_mm, levels, left, top, is_on_skin);
      if (std::popcount(reading.used) >= kLeastReadings) view.readings.push_back(reading);
    }
  }
  read_beside(depth_mm, levels, expected, view.beside);
  return view;
}

ExpectedReading expected_reading(const SkinReading& reading,
                                 const Image<float>& expected,
                                 const PinholeCamera& camera) {
  const int left = reading.column * kBlockPx;
  const int top = reading.row * kBlockPx;
  if (!is_one_patch(expected, left, top)) return {};
  ExpectedReading result;
  Eigen::Vector2f slope = Eigen::Vector2f::Zero();
  for (int y = 0; y < kBlockPx; ++y) {
    for (int x = 0; x < kBlockPx; ++x) {
      const float z_mm = expected(left + x, top + y);
      // A plane by least squares over the whole block: offsets of -1.5 to 1.5 px, 5 on average of
      // the squares over 4.
      slope += z_mm * Eigen::Vector2f(static_cast<float>(x) - 1.5F, static_cast<float>(y) - 1.5F);
      if ((reading.used >> (y * kBlockPx + x)) & 1U) result.z_mm += z_mm;
    }
  }
  slope /= 20.0F;
  result.z_mm /= static_cast<float>(std::popcount(reading.used));
  // The surface (ray z) changes by these from a pixel to the next.
  const Eigen::Vector2d pixel = reading.pixel.cast<double>();
  const auto ray_at = [&](double x, double y) {
    const Eigen::Vector2d ray = camera.ray(pixel + Eigen::Vector2d(x, y));
    return Eigen::Vector3d(ray.x(), ray.y(), 1.0);
  };
  const auto z_mm = static_cast<double>(result.z_mm);
  const Eigen::Vector3d middle = ray_at(0.0, 0.0);
  const Eigen::Vector3d along_x =
      z_mm * (ray_at(0.5, 0.0) - ray_at(-0.5, 0.0)) + static_cast<double>(slope.x()) * middle;
  const Eigen::Vector3d along_y =
      z_mm * (ray_at(0.0, 0.5) - ray_at(0.0, -0.5)) + static_cast<double>(slope.y()) * middle;
  // x right, y down, z forward: y across x looks back at the camera.
  result.normal = along_y.cross(along_x).normalized().cast<float>();
  return result;
}

}  // namespace mor
