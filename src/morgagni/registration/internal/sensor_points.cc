// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/sensor_points.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

/// Cosines between normal and ray: nothing below the first is used, all from the second on in full.
constexpr float kGrazingCosine = 0.17F;  // 80 degrees
constexpr float kFrontalCosine = 0.42F;  // 65 degrees

}  // namespace

float axial_noise_mm(float z_mm) {
  const float beyond_m = z_mm * 1e-3F - 0.4F;
  return 1.2F + 1.9F * beyond_m * beyond_m;
}

std::vector<SensorPoint> weighted_points(const PointCloud& moving, std::size_t stride) {
  std::vector<SensorPoint> points;
  points.reserve(moving.size() / stride + 1);
  for (std::size_t i = 0; i < moving.size(); i += stride) {
    const Eigen::Vector3f& point = moving.points[i];
    const Eigen::Vector3f& normal = moving.normals[i];
    const float cosine = -normal.dot(point) / point.norm();
    const float trust =
        std::min(1.0F, (cosine - kGrazingCosine) / (kFrontalCosine - kGrazingCosine));
    if (!(trust > 0.0F)) continue;
    const float noise_mm = axial_noise_mm(point.z());
    points.push_back({point, normal, trust / (noise_mm * noise_mm)});
  }
  return points;
}

}  // namespace mor::internal
