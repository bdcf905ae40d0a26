// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/icp_registration.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/alignment_input.h"

namespace mor::internal {
namespace {

constexpr std::size_t kMinPairs = 3;
constexpr float kExplainedMm = 5.0F;
/// Where no moving point is nearer to the fixed surface than this, the start has nothing to do with
/// it: ICP would still slide somewhere and call it an end.
constexpr float kMaxStartDistanceMm = 500.0F;

struct Pair {
  std::uint32_t moving = 0;
  std::uint32_t fixed = 0;
  float distance_sq_mm2 = 0.0F;
};

std::vector<Pair> find_pairs(const KdTree& tree,
                             const PointCloud& moving,
                             const Eigen::Isometry3d& fixed_from_moving) {
  const Eigen::Isometry3f pose = fixed_from_moving.cast<float>();
  std::vector<Pair> pairs;
  pairs.reserve(moving.size());
  for (std::uint32_t i = 0; i < moving.size(); ++i) {
    const auto nearest = tree.nearest(pose * moving.points[i]);
    pairs.push_back({i, nearest.index, nearest.distance_sq_mm2});
  }
  return pairs;
}

/// Chetverikov 2002, step 2: sort by distance, keep the closest share. Ties go by index, so that
/// the result does not depend on the sort.
void trim(std::vector<Pair>& pairs, double overlap) {
  const auto num_kept =
      std::max(kMinPairs,
               static_cast<std::size_t>(std::lround(overlap * static_cast<double>(pairs.size()))));
  if (num_kept >= pairs.size()) return;
  std::nth_element(pairs.begin(),
                   pairs.begin() + static_cast<std::ptrdiff_t>(num_kept),
                   pairs.end(),
                   [](const Pair& a, const Pair& b) {
                     return std::pair(a.distance_sq_mm2, a.moving) <
                            std::pair(b.distance_sq_mm2, b.moving);
                   });
  pairs.resize(num_kept);
  std::sort(
      pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.moving < b.moving; });
}

double rms_mm(std::span<const Pair> pairs) {
  double sum = 0.0;
  for (const auto& pair : pairs) sum += static_cast<double>(pair.distance_sq_mm2);
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

double explained_fraction(std::span<const Pair> pairs) {
  const auto count = std::count_if(pairs.begin(), pairs.end(), [](const Pair& pair) {
    return pair.distance_sq_mm2 <= kExplainedMm * kExplainedMm;
  });
  return static_cast<double>(count) / static_cast<double>(pairs.size());
}

bool any_near(std::span<const Pair> pairs) {
  return std::any_of(pairs.begin(), pairs.end(), [](const Pair& pair) {
    return pair.distance_sq_mm2 < kMaxStartDistanceMm * kMaxStartDistanceMm;
  });
}

/// Besl & McKay 1992, section III.C: the motion from the moving points to their nearest fixed ones.
Eigen::Isometry3d fit_pairs(std::span<const Pair> pairs,
                            const PointCloud& moving,
                            std::span<const Eigen::Vector3f> fixed) {
  Eigen::Vector3d moving_centroid = Eigen::Vector3d::Zero();
  Eigen::Vector3d fixed_centroid = Eigen::Vector3d::Zero();
  for (const auto& pair : pairs) {
    moving_centroid += moving.points[pair.moving].cast<double>();
    fixed_centroid += fixed[pair.fixed].cast<double>();
  }
  moving_centroid /= static_cast<double>(pairs.size());
  fixed_centroid /= static_cast<double>(pairs.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& pair : pairs) {
    covariance += (moving.points[pair.moving].cast<double>() - moving_centroid) *
                  (fixed[pair.fixed].cast<double>() - fixed_centroid).transpose();
  }
  return fit_rigid(fixed_centroid, moving_centroid, covariance);
}

}  // namespace

IcpRegistration::IcpRegistration(std::shared_ptr<const FixedSurface> fixed,
                                 const RegistrationOptions& options)
    : fixed_(std::move(fixed)), options_(options), tree_(fixed_->mesh.vertices) {}

Result<RegistrationResult> IcpRegistration::align(const PointCloud& moving,
                                                  const Eigen::Isometry3d& fixed_from_moving_init,
                                                  StartQuality /*start*/) const {
  MOR_CHECK(check_alignment_input(moving, fixed_from_moving_init, /*needs_normals=*/false));
  RegistrationResult result;
  result.fixed_from_moving = fixed_from_moving_init;
  if (moving.size() < kMinPairs) {
    result.status = RegistrationStatus::kTooFewPairs;
    result.num_pairs = static_cast<int>(moving.size());
    return result;
  }
  double last_rms_mm = std::numeric_limits<double>::infinity();
  while (result.num_iterations < options_.max_iterations) {
    auto pairs = find_pairs(tree_, moving, result.fixed_from_moving);
    if (result.num_iterations == 0 && !any_near(pairs)) {
      result.status = RegistrationStatus::kTooFewPairs;
      break;
    }
    result.explained_fraction = explained_fraction(pairs);
    if (options_.method == RegistrationMethod::kTrimmedIcp) trim(pairs, options_.overlap);
    result.rms_distance_mm = rms_mm(pairs);
    result.num_pairs = static_cast<int>(pairs.size());
    if (last_rms_mm - result.rms_distance_mm <=
        options_.convergence_threshold * result.rms_distance_mm) {
      result.status = RegistrationStatus::kConverged;
      break;
    }
    last_rms_mm = result.rms_distance_mm;
    result.fixed_from_moving = fit_pairs(pairs, moving, fixed_->mesh.vertices);
    ++result.num_iterations;
  }
  return result;
}

}  // namespace mor::internal
