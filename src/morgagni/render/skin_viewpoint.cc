// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/skin_viewpoint.h"

#include <algorithm>
#include <cmath>

namespace mor {
namespace {

constexpr int kMaxSidePx = 4096;
constexpr double kMinZoom = 0.1;
constexpr double kMaxZoom = 50.0;
/// Far enough to look natural, near enough to be seen around.
constexpr double kDistanceInRadii = 4.0;
constexpr double kFill = 0.94;  ///< Of the picture's shorter side, at zoom 1.

}  // namespace

SkinSphere bounding_sphere(const TriangleMesh& skin) {
  if (skin.vertices.empty()) return {};
  const Eigen::Vector3f center = skin.bounds().center();
  float farthest_sq = 1.0F;
  for (const auto& vertex : skin.vertices) {
    farthest_sq = std::max(farthest_sq, (vertex - center).squaredNorm());
  }
  return {center.cast<double>(), std::sqrt(static_cast<double>(farthest_sq))};
}

/// Patient coordinates are LPS: +x the body's left, +y its back, +z its head.
Eigen::Isometry3d view_from_ct(const SkinViewpoint& viewpoint, const SkinSphere& skin) {
  const double sin_yaw = std::sin(viewpoint.yaw_rad);
  const double cos_yaw = std::cos(viewpoint.yaw_rad);
  const double sin_pitch = std::sin(viewpoint.pitch_rad);
  const double cos_pitch = std::cos(viewpoint.pitch_rad);
  const Eigen::Vector3d towards_eye(sin_yaw * cos_pitch, -cos_yaw * cos_pitch, sin_pitch);
  const Eigen::Vector3d up(-sin_yaw * sin_pitch, cos_yaw * sin_pitch, cos_pitch);
  Eigen::Matrix3d axes;
  axes.row(0) = up.cross(towards_eye);
  axes.row(1) = -up;
  axes.row(2) = -towards_eye;
  const Eigen::Vector3d eye =
      skin.center + viewpoint.target_mm + kDistanceInRadii * skin.radius_mm * towards_eye;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = axes;
  pose.translation() = -(axes * eye);
  return pose;
}

PinholeCamera view_camera(const SkinViewpoint& viewpoint) {
  PinholeCamera camera;
  camera.width_px = std::clamp(viewpoint.width_px, 1, kMaxSidePx);
  camera.height_px = std::clamp(viewpoint.height_px, 1, kMaxSidePx);
  // A sphere's outline is where rays touch it: tan(asin(radius / distance)).
  const double outline = std::tan(std::asin(1.0 / kDistanceInRadii));
  const double half_side_px = 0.5 * std::min(camera.width_px, camera.height_px);
  const double zoom =
      std::isfinite(viewpoint.zoom) ? std::clamp(viewpoint.zoom, kMinZoom, kMaxZoom) : 1.0;
  camera.focal_x_px = zoom * kFill * half_side_px / outline;
  camera.focal_y_px = camera.focal_x_px;
  camera.center_x_px = 0.5 * (camera.width_px - 1);
  camera.center_y_px = 0.5 * (camera.height_px - 1);
  return camera;
}

}  // namespace mor
