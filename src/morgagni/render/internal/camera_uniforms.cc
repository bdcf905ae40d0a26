// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/camera_uniforms.h"

#include <algorithm>
#include <limits>

namespace mor::internal {
namespace {

constexpr double kNearestMm = 1.0;
/// 24 bits of depth part surfaces 0.1 mm apart at the far end of this ratio.
constexpr double kMaxFarOverNear = 2000.0;
constexpr double kMaxRadiusSq = 25.0;  ///< Rays up to 79 degrees off the axis.

/// The largest (x/z)^2 + (y/z)^2 up to which the radial polynomial still grows.
double max_radius_sq(const std::array<double, 5>& d) {
  constexpr int kSteps = 1000;
  for (int i = 1; i <= kSteps; ++i) {
    const double r2 = kMaxRadiusSq * i / kSteps;
    const double slope = 1.0 + r2 * (3.0 * d[0] + r2 * (5.0 * d[1] + r2 * 7.0 * d[4]));
    if (slope <= 0.0) return kMaxRadiusSq * (i - 1) / kSteps + 1e-6;
  }
  return kMaxRadiusSq;
}

struct DepthRange {
  double nearest_mm = std::numeric_limits<double>::max();
  double farthest_mm = std::numeric_limits<double>::lowest();
};

DepthRange depth_range(const Eigen::AlignedBox3f& bounds, const Eigen::Isometry3d& camera_from_ct) {
  DepthRange range;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3f::CornerType>(i);
    const double z = (camera_from_ct * bounds.corner(corner).cast<double>()).z();
    range.nearest_mm = std::min(range.nearest_mm, z);
    range.farthest_mm = std::max(range.farthest_mm, z);
  }
  return range;
}

}  // namespace

std::optional<CameraUniforms> camera_uniforms(const PinholeCamera& camera,
                                              const Eigen::Isometry3d& camera_from_ct,
                                              const Eigen::AlignedBox3f& bounds,
                                              const PixelBox& box) {
  const DepthRange range = depth_range(bounds, camera_from_ct);
  // A little room, so that nothing is cut by rounding.
  const double far_mm = range.farthest_mm + 1.0;
  if (!(far_mm > kNearestMm + 1.0)) return std::nullopt;
  const double near_mm = std::max({range.nearest_mm - 1.0, kNearestMm, far_mm / kMaxFarOverNear});

  CameraUniforms uniforms;
  uniforms.camera_from_ct = camera_from_ct.cast<float>().matrix();
  // Pixel centres are whole numbers: the box's left edge is half a pixel before its first one.
  uniforms.focal_ndc = {static_cast<float>(2.0 * camera.focal_x_px / box.width),
                        static_cast<float>(2.0 * camera.focal_y_px / box.height)};
  uniforms.center_ndc = {
      static_cast<float>(2.0 * (camera.center_x_px + 0.5 - box.left) / box.width - 1.0),
      static_cast<float>(2.0 * (camera.center_y_px + 0.5 - box.top) / box.height - 1.0)};
  std::transform(camera.distortion.begin(),
                 camera.distortion.end(),
                 uniforms.distortion.begin(),
                 [](double k) { return static_cast<float>(k); });
  if (camera.has_distortion()) {
    uniforms.max_radius_sq = static_cast<float>(max_radius_sq(camera.distortion));
  }
  const double span_mm = far_mm - near_mm;
  uniforms.depth_clip = {static_cast<float>((far_mm + near_mm) / span_mm),
                         static_cast<float>(-2.0 * far_mm * near_mm / span_mm)};
  uniforms.depth_range_mm = {static_cast<float>(near_mm), static_cast<float>(far_mm)};
  return uniforms;
}

}  // namespace mor::internal
