// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_finding.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "morgagni/registration/internal/start_decision.h"

namespace mor::internal {
namespace {

constexpr double kSettledMargin = 0.3;

/// How far two poses put the body apart: the largest distance of the corners of its bounds.
double distance_mm(const Eigen::Isometry3d& a,
                   const Eigen::Isometry3d& b,
                   const Eigen::AlignedBox3d& bounds) {
  const Eigen::Isometry3d b_from_a = b * a.inverse();
  double most_mm = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    most_mm = std::max(most_mm, (b_from_a * p - p).norm());
  }
  return most_mm;
}

bool passes_by(const std::vector<StartFinding>& findings,
               std::size_t num_tries,
               double least_margin) {
  return !findings.empty() &&
         margin(findings[0].agreement, runner_up_share(findings), num_tries) >= least_margin;
}

}  // namespace

StartPlane plane_of(const StartFinding& finding) {
  StartPlane plane;
  plane.normal = (finding.on_plane.linear().transpose() * finding.up_ct).cast<float>();
  plane.offset_mm =
      static_cast<float>(finding.foot_ct_mm - finding.up_ct.dot(finding.on_plane.translation()));
  plane.is_supposed = finding.scene->plane.is_supposed;
  return plane;
}

void keep_best(std::vector<StartFinding>& findings,
               std::size_t count,
               double near_mm,
               const Eigen::AlignedBox3d& bounds) {
  // Indices are sorted: std::stable_sort's buffer is not aligned for Eigen.
  std::vector<std::size_t> order(findings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&findings](std::size_t a, std::size_t b) {
    return findings[a].score > findings[b].score;
  });
  std::vector<StartFinding> kept;
  for (const std::size_t i : order) {
    if (kept.size() == count) break;
    auto& item = findings[i];
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const StartFinding& other) {
      return distance_mm(item.ct_from_depth, other.ct_from_depth, bounds) < near_mm;
    });
    if (is_new) kept.push_back(std::move(item));
  }
  findings = std::move(kept);
}

double runner_up_share(const std::vector<StartFinding>& findings) {
  if (findings.size() < 2 || !(findings[0].score > 0.0)) return 0.0;
  return std::max(0.0, findings[1].score / findings[0].score);
}

bool passes(const std::vector<StartFinding>& findings, std::size_t num_tries) {
  return passes_by(findings, num_tries, 0.0);
}

bool settles(const std::vector<StartFinding>& findings) {
  return passes_by(findings, 1, kSettledMargin);
}

}  // namespace mor::internal
