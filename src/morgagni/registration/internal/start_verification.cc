// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_verification.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>
#include <utility>

#include "morgagni/geometry/depth_raster.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

constexpr float kGlanceFacing = 0.3F;
constexpr float kSpacing = 1.0F / 36.0F;  ///< Of the skin's points, of the body's extent.
constexpr float kLargePlane = 0.12F;      ///< Share of the picture's surface.
constexpr float kInPlaneMm = 3.0F;
constexpr float kNoises = 2.0F;
/// Skin is floating only if the camera looks past it by so many tolerances.
constexpr float kFloatingTolerances = 1.2F;

/// The reading in the 3x3 pixels around (x, y) that comes nearest to `z`; 0 without any.
float nearest_reading(const StartPicture& picture, int x, int y, float z) {
  float nearest = 0.0F;
  for (int v = std::max(0, y - 1); v <= std::min(picture.z_mm.height() - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(picture.z_mm.width() - 1, x + 1); ++u) {
      const float reading = picture.z_mm(u, v);
      if (reading > 0.0F && std::abs(reading - z) < std::abs(nearest - z)) nearest = reading;
    }
  }
  return nearest;
}

bool is_in_large_plane(const std::vector<StartPlane>& planes,
                       const Eigen::Vector3f& p,
                       float reach_mm) {
  return std::any_of(planes.begin(), planes.end(), [&](const StartPlane& plane) {
    return plane.share >= kLargePlane && std::abs(plane.height_mm(p)) < reach_mm;
  });
}

void judge(float reading, float expected, float tolerance_mm, SkinAgreement& agreement) {
  agreement.num_seen += 1.0;
  if (reading > expected + kFloatingTolerances * tolerance_mm) {
    agreement.num_floating += 1.0;
  } else if (reading < expected - tolerance_mm) {
    agreement.num_hidden += 1.0;
  } else {
    const float ratio = std::min(1.0F, std::abs(reading - expected) / tolerance_mm);
    agreement.num_agree += static_cast<double>((1.0F - ratio * ratio) * (1.0F - ratio * ratio));
  }
}

}  // namespace

StartVerifier::StartVerifier(std::shared_ptr<const FixedSurface> fixed, float body_extent_mm)
    : fixed_(std::move(fixed)) {
  std::unordered_set<std::uint64_t> taken;
  for (std::size_t i = 0; i < fixed_->mesh.vertices.size(); ++i) {
    const Eigen::Vector3f cell = fixed_->mesh.vertices[i] / (kSpacing * body_extent_mm);
    const auto key = [](float v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v)) + 0x10000) &
             0x1FFFFF;
    };
    if (taken.insert(key(cell.x()) << 42U | key(cell.y()) << 21U | key(cell.z())).second) {
      points_.push_back({fixed_->mesh.vertices[i], fixed_->mesh.normals[i]});
    }
  }
}

SkinAgreement StartVerifier::glance(const StartPicture& picture,
                                    const Eigen::Isometry3d& ct_from_depth,
                                    float tolerance_mm) const {
  SkinAgreement agreement;
  const Eigen::Isometry3f depth_from_ct = ct_from_depth.inverse().cast<float>();
  const Eigen::Vector3f camera = ct_from_depth.translation().cast<float>();
  const auto fx = static_cast<float>(picture.camera.focal_x_px);
  const auto fy = static_cast<float>(picture.camera.focal_y_px);
  const auto cx = static_cast<float>(picture.camera.center_x_px);
  const auto cy = static_cast<float>(picture.camera.center_y_px);
  for (const auto& [point, normal] : points_) {
    const Eigen::Vector3f to_camera = camera - point;
    if (normal.dot(to_camera) < kGlanceFacing * to_camera.norm()) continue;
    const Eigen::Vector3f p = depth_from_ct * point;
    if (p.z() < 1.0F) continue;
    const float x = fx * p.x() / p.z() + cx + 0.5F;
    const float y = fy * p.y() / p.z() + cy + 0.5F;
    if (!(x >= 0.0F && y >= 0.0F && x < static_cast<float>(picture.z_mm.width()) &&
          y < static_cast<float>(picture.z_mm.height()))) {
      continue;
    }
    const float reading = picture.z_mm(static_cast<int>(x), static_cast<int>(y));
    if (reading > 0.0F) judge(reading, p.z(), tolerance_mm, agreement);
  }
  return agreement;
}

SkinAgreement StartVerifier::look(const StartPicture& picture,
                                  const std::vector<StartPlane>& planes,
                                  const Eigen::Isometry3d& ct_from_depth,
                                  float tolerance_mm) const {
  SkinAgreement agreement;
  const DepthRaster raster = rasterize_depth(fixed_->mesh, picture.camera, ct_from_depth.inverse());
  for (int y = 0; y < raster.depth_mm.height(); ++y) {
    for (int x = 0; x < raster.depth_mm.width(); ++x) {
      const float expected = raster.depth_mm(x, y);
      if (expected <= 0.0F) continue;
      const float reading = nearest_reading(picture, x, y, expected);
      if (reading <= 0.0F) continue;
      const float noise_mm = kNoises * axial_noise_mm(expected);
      if (is_in_large_plane(planes, picture.point_at(x, y, expected), kInPlaneMm + noise_mm)) {
        continue;
      }
      judge(reading, expected, tolerance_mm + noise_mm, agreement);
    }
  }
  return agreement;
}

}  // namespace mor::internal
