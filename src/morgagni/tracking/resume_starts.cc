// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/resume_starts.h"

#include <array>
#include <numbers>

namespace mor {
namespace {

constexpr double kTurnRad = 20.0 * std::numbers::pi / 180.0;
constexpr double kFarTurnRad = 40.0 * std::numbers::pi / 180.0;

Eigen::Vector3d centroid(const PointCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : cloud.points) sum += point.cast<double>();
  return sum / static_cast<double>(cloud.size());
}

}  // namespace

std::vector<Eigen::Isometry3d> resume_starts(const LastSeen& last,
                                             const PointCloud& surface,
                                             std::size_t round) {
  // Line of sight, then the picture's two directions.
  const std::array<Eigen::Vector3d, kResumeRounds> axes = {
      Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()};
  const Eigen::Vector3d now_mm = centroid(surface);
  Eigen::Isometry3d moved = last.ct_from_depth;
  moved.translation() += last.center_mm - moved * now_mm;
  std::vector<Eigen::Isometry3d> starts = {last.ct_from_depth, moved};
  for (const double angle_rad : {kTurnRad, -kTurnRad, kFarTurnRad, -kFarTurnRad}) {
    starts.push_back(moved * Eigen::Translation3d(now_mm) *
                     Eigen::AngleAxisd(angle_rad, axes[round % kResumeRounds]) *
                     Eigen::Translation3d(-now_mm));
  }
  return starts;
}

}  // namespace mor
