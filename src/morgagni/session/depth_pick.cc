// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/depth_pick.h"

#include <algorithm>
#include <vector>

namespace mor {
namespace {

constexpr double kReachPx = 4.0;         ///< A reading farther from the pixel is not meant.
constexpr double kSameSurfaceMm = 15.0;  ///< Behind the nearest reading by more: another surface.

/// The part of the depth picture that can show what the colour pixel sees, at any distance.
Eigen::AlignedBox2i window(const RgbdFrame& frame, const Eigen::Vector2d& color_pixel) {
  constexpr double kNearMm = 100.0;
  constexpr double kFarMm = 10000.0;
  const PinholeCamera& depth_camera = frame.calibration->depth;
  const PinholeCamera& color_camera = frame.calibration->color;
  const Eigen::Isometry3d& color_from_depth = frame.calibration->color_from_depth;
  const Eigen::AlignedBox2i all(
      Eigen::Vector2i::Zero(),
      Eigen::Vector2i(frame.depth_mm.width() - 1, frame.depth_mm.height() - 1));
  const Eigen::Vector3d ray = color_camera.ray(color_pixel).homogeneous();
  Eigen::AlignedBox2d box;
  for (const double z_mm : {kNearMm, kFarMm}) {
    const auto pixel = depth_camera.project(color_from_depth.inverse() * (z_mm * ray));
    if (!pixel || !pixel->allFinite() || pixel->cwiseAbs().maxCoeff() > 1e6) return all;
    box.extend(*pixel);
  }
  const double reach_px = kReachPx * depth_camera.focal_x_px / color_camera.focal_x_px + 2.0;
  const Eigen::AlignedBox2i around((box.min().array() - reach_px).floor().matrix().cast<int>(),
                                   (box.max().array() + reach_px).ceil().matrix().cast<int>());
  return around.intersection(all);
}

}  // namespace

std::optional<Eigen::Vector3d> depth_point_at(const RgbdFrame& frame,
                                              const Eigen::Vector2d& color_pixel) {
  const PinholeCamera& depth_camera = frame.calibration->depth;
  const PinholeCamera& color_camera = frame.calibration->color;
  const Eigen::Isometry3d& color_from_depth = frame.calibration->color_from_depth;
  std::vector<Eigen::Vector3d> seen;
  const Eigen::AlignedBox2i box = window(frame, color_pixel);
  for (int y = box.min().y(); y <= box.max().y(); ++y) {
    for (int x = box.min().x(); x <= box.max().x(); ++x) {
      const double z_mm = frame.depth_mm(x, y);
      if (z_mm == 0.0) continue;
      const Eigen::Vector3d point = z_mm * depth_camera.ray(Eigen::Vector2d(x, y)).homogeneous();
      const auto pixel = color_camera.project(color_from_depth * point);
      if (pixel && (*pixel - color_pixel).squaredNorm() <= kReachPx * kReachPx) {
        seen.push_back(point);
      }
    }
  }
  if (seen.empty()) return std::nullopt;
  const auto nearer = [](const auto& a, const auto& b) { return a.z() < b.z(); };
  const double nearest_mm = std::min_element(seen.begin(), seen.end(), nearer)->z();
  std::erase_if(seen, [&](const auto& point) { return point.z() > nearest_mm + kSameSurfaceMm; });
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : seen) sum += point;
  return sum / static_cast<double>(seen.size());
}

}  // namespace mor
