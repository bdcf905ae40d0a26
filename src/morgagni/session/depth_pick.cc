// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/depth_pick.h"

#include <algorithm>
#include <vector>

namespace mor {
namespace {

constexpr double kReachPx = 4.0;         ///< A reading farther from the pixel is not meant.
constexpr double kSameSurfaceMm = 15.0;  ///< Behind the nearest reading by more: another surface.

}  // namespace

std::optional<Eigen::Vector3d> depth_point_at(const RgbdFrame& frame,
                                              const Eigen::Vector2d& color_pixel) {
  const auto& [depth_camera, color_camera, color_from_depth] = *frame.calibration;
  std::vector<Eigen::Vector3d> seen;
  for (int y = 0; y < frame.depth_mm.height(); ++y) {
    for (int x = 0; x < frame.depth_mm.width(); ++x) {
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
