// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

constexpr std::size_t kSearchPoints = 600;
constexpr std::size_t kFullPoints = 5000;
constexpr std::size_t kStandingPoints = 2500;
constexpr float kLeastHeightMm = 6.0F;
constexpr float kLeastHeightNoises = 2.0F;
/// How much higher than the body a point may be: a table found too low, a cushion.
constexpr float kHeightSlack = 0.25F;
constexpr float kNormalRadius = 0.04F;  ///< Of the body's extent.

struct Pixel {
  std::int16_t x, y;
};

/// One of the pixels in each cell of space of this side, in the picture's order.
std::vector<Pixel> thinned(const StartPicture& picture,
                           const std::vector<Pixel>& pixels,
                           float side_mm) {
  std::unordered_set<std::uint64_t> taken;
  std::vector<Pixel> kept;
  for (const auto& pixel : pixels) {
    const Eigen::Vector3f cell = picture.point(pixel.x, pixel.y) / side_mm;
    const auto key = [](float v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v)) + 0x10000) &
             0x1FFFFF;
    };
    if (taken.insert(key(cell.x()) << 42U | key(cell.y()) << 21U | key(cell.z())).second) {
      kept.push_back(pixel);
    }
  }
  return kept;
}

/// At most about `count` pixels, even over the surface.
std::vector<Pixel> spread(const StartPicture& picture,
                          const std::vector<Pixel>& pixels,
                          std::size_t count,
                          float side_mm) {
  std::vector<Pixel> kept = thinned(picture, pixels, side_mm);
  for (int i = 0; i < 8 && kept.size() > count; ++i) {
    side_mm *=
        std::max(1.05F, std::sqrt(static_cast<float>(kept.size()) / static_cast<float>(count)));
    kept = thinned(picture, pixels, side_mm);
  }
  return kept;
}

PointCloud cloud_of(const StartPicture& picture,
                    const std::vector<Pixel>& pixels,
                    float normal_radius_mm,
                    bool is_even = false) {
  PointCloud cloud;
  for (const auto& [x, y] : pixels) {
    const auto normal = picture.normal(x, y, normal_radius_mm);
    if (!normal) continue;
    cloud.points.push_back(is_even ? picture.even_point(x, y) : picture.point(x, y));
    cloud.normals.push_back(*normal);
  }
  return cloud;
}

/// Up is the plane's normal; the rest is any.
Eigen::Isometry3d table_from_depth(const StartPlane& plane, const Eigen::Vector3d& middle) {
  const Eigen::Vector3d up = plane.normal.cast<double>().normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d level = up.unitOrthogonal();
  pose.linear().row(0) = level;
  pose.linear().row(1) = up.cross(level);
  pose.linear().row(2) = up;
  const Eigen::Vector3d foot =
      middle - up * (up.dot(middle) - static_cast<double>(plane.offset_mm));
  pose.translation() = -(pose.linear() * foot);
  return pose;
}

}  // namespace

StartScene make_scene(const StartPicture& picture,
                      const StartPlane& plane,
                      float body_height_mm,
                      float body_extent_mm) {
  StartScene scene;
  scene.plane = plane;
  std::vector<Pixel> pixels;
  for (int y = 0; y < picture.z_mm.height(); ++y) {
    for (int x = 0; x < picture.z_mm.width(); ++x) {
      const float z = picture.z_mm(x, y);
      if (z <= 0.0F) continue;
      const float height_mm = plane.height_mm(picture.point(x, y));
      if (height_mm < kLeastHeightMm + kLeastHeightNoises * axial_noise_mm(z) ||
          height_mm > (1.0F + kHeightSlack) * body_height_mm) {
        continue;
      }
      pixels.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)});
    }
  }
  const float normal_radius_mm = kNormalRadius * body_extent_mm;
  const auto full = spread(picture, pixels, kFullPoints, body_extent_mm / 150.0F);
  scene.full = cloud_of(picture, full, normal_radius_mm);
  scene.even = take_points(cloud_of(picture, full, normal_radius_mm, true));
  const auto few = spread(picture, full, kSearchPoints, body_extent_mm / 30.0F);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& [x, y] : few) middle += picture.point(x, y).cast<double>();
  if (!few.empty()) middle /= static_cast<double>(few.size());
  scene.table_from_depth = table_from_depth(plane, middle);
  const Eigen::Isometry3f pose = scene.table_from_depth.cast<float>();
  for (const auto& [x, y] : few) scene.search_points.push_back(pose * picture.point(x, y));
  for (const auto& [x, y] : full) scene.dense_points.push_back(pose * picture.point(x, y));
  return scene;
}

PointCloud standing_points(const StartPicture& picture,
                           const std::vector<StartPlane>& planes,
                           float body_extent_mm) {
  std::vector<Pixel> pixels;
  for (int y = 0; y < picture.z_mm.height(); ++y) {
    for (int x = 0; x < picture.z_mm.width(); ++x) {
      const float z = picture.z_mm(x, y);
      if (z <= 0.0F) continue;
      const float reach_mm = kLeastHeightMm + kLeastHeightNoises * axial_noise_mm(z);
      if (is_in_large_plane(planes, picture.point(x, y), reach_mm)) continue;
      pixels.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)});
    }
  }
  return cloud_of(picture,
                  spread(picture, pixels, kStandingPoints, body_extent_mm / 100.0F),
                  kNormalRadius * body_extent_mm,
                  true);
}

}  // namespace mor::internal
