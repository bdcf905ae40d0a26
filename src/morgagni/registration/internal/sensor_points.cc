// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/sensor_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mor::internal {
namespace {

/// Cosines between normal and ray: nothing below the first is used, all from the second on in full.
constexpr float kGrazingCosine = 0.17F;  // 80 degrees
constexpr float kFrontalCosine = 0.42F;  // 65 degrees

/// The widest gap that a row goes over.
constexpr float kRowGapMm = 15.0F;

template <class Number>
Number noise_mm_at(const Number& z_mm) {
  const Number beyond_m = z_mm * 1e-3F - 0.4F;
  return 1.2F + 1.9F * beyond_m * beyond_m;
}

void weigh(PointLanes& p) {
  const Lanes range_sq = p.x * p.x + p.y * p.y + p.z * p.z;
  Lanes range = {};
  for (int i = 0; i < kLanes; ++i) range[i] = std::sqrt(range_sq[i]);
  const Lanes cosine = -(p.normal_x * p.x + p.normal_y * p.y + p.normal_z * p.z) / range;
  const Lanes trust =
      min_of((cosine - kGrazingCosine) / (kFrontalCosine - kGrazingCosine), Lanes{} + 1.0F);
  const Lanes noise_mm = noise_mm_at(p.z);
  // Written so that a point at the camera itself has none.
  p.weight = trust > 0.0F ? trust / (noise_mm * noise_mm) : Lanes{};
}

/// Counts, for each point, its unbroken neighbours: first forwards, then backwards.
void find_rows(const PointCloud& moving,
               const std::vector<std::uint32_t>& taken,
               std::vector<RowReach>& rows) {
  rows.resize(taken.size());
  std::size_t reach = 0;
  const auto extend = [&reach](bool is_connected) {
    reach = is_connected ? std::min(kRowReach, reach + 1) : 0;
    return static_cast<std::uint8_t>(reach);
  };
  for (std::size_t i = 1; i < taken.size(); ++i) {
    const Eigen::Vector3f gap = moving.points[taken[i]] - moving.points[taken[i - 1]];
    rows[i].before = extend(gap.squaredNorm() <= kRowGapMm * kRowGapMm);
  }
  reach = 0;
  for (std::size_t i = taken.size(); i-- > 1;) rows[i - 1].after = extend(rows[i].before > 0);
}

}  // namespace

float axial_noise_mm(float z_mm) {
  return noise_mm_at(z_mm);
}

std::vector<std::uint32_t> points_in_box(const PointCloud& moving,
                                         const Eigen::Isometry3d& fixed_from_moving,
                                         const Eigen::AlignedBox3f& box_mm) {
  const Eigen::Matrix3f rotation = fixed_from_moving.linear().cast<float>();
  // About the box's centre: the cast to float must not round a far camera's place.
  const Eigen::Vector3f shift =
      (fixed_from_moving.translation() - box_mm.center().cast<double>()).cast<float>();
  const Eigen::Vector3f half = 0.5F * box_mm.sizes();
  std::vector<std::uint32_t> kept(moving.size());
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < moving.size(); ++i) {
    const Eigen::Vector3f p = (rotation * moving.points[i] + shift).cwiseAbs();
    kept[count] = i;
    count += (p.x() <= half.x()) & (p.y() <= half.y()) & (p.z() <= half.z()) ? 1 : 0;
  }
  kept.resize(count);
  return kept;
}

SensorPoints take_points(const PointCloud& moving,
                         std::span<const std::uint32_t> kept,
                         std::size_t run_length,
                         std::size_t stride) {
  SensorPoints points;
  points.stride = stride;
  std::vector<std::uint32_t> taken;
  taken.reserve(kept.size() / stride + run_length);
  for (std::size_t run = 0; run < kept.size(); run += run_length * stride) {
    const std::size_t end = std::min(run + run_length, kept.size());
    taken.insert(taken.end(),
                 kept.begin() + static_cast<std::ptrdiff_t>(run),
                 kept.begin() + static_cast<std::ptrdiff_t>(end));
  }
  points.size = taken.size();
  points.groups.assign((taken.size() + kLanes - 1) / kLanes, PointLanes{});
  for (std::size_t i = 0; i < taken.size(); ++i) {
    PointLanes& group = points.groups[i / kLanes];
    const auto lane = static_cast<int>(i % kLanes);
    const Eigen::Vector3f& point = moving.points[taken[i]];
    const Eigen::Vector3f& normal = moving.normals[taken[i]];
    group.x[lane] = point.x();
    group.y[lane] = point.y();
    group.z[lane] = point.z();
    group.normal_x[lane] = normal.x();
    group.normal_y[lane] = normal.y();
    group.normal_z[lane] = normal.z();
  }
  for (auto& group : points.groups) {
    weigh(group);
    points.sum_weights += sum_of(group.weight);
  }
  find_rows(moving, taken, points.rows);
  return points;
}

SensorPoints take_points(const PointCloud& moving) {
  std::vector<std::uint32_t> kept(moving.size());
  std::iota(kept.begin(), kept.end(), 0U);
  return take_points(moving, kept, 1, 1);
}

}  // namespace mor::internal
