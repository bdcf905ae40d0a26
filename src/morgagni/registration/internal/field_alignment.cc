// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/field_alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/surface_shape.h"

namespace mor::internal {
namespace {

/// Moving points farther than this beside the field, at the start, are not the body's.
constexpr float kReachMm = 50.0F;
/// About so many points are few.
constexpr std::size_t kFewPoints = 1000;
/// Runs of so many neighbours, about kRunPoints points in all.
constexpr std::size_t kRunLength = 24;
constexpr std::size_t kRunPoints = 3000;

/// Neighbouring readings err together (smooth sensor errors, the skin's own shape): so many of them
/// count as one when the data is weighed against the start.
constexpr double kCorrelatedReadings = 10.0;
constexpr int kMinPairs = 30;
/// The variance of the difference of two rows' means over that of a point, were points independent.
constexpr double kRowsShare = 2.0 / (2 * kRowReach + 1);
/// A sensor may be better than the noise model, the skin's own facets are not: points scatter by
/// this at least, over the variance of a single reading.
constexpr double kLeastMeanSq = 0.1;
/// A direction in which the data fixes the pose to no better than this is open.
constexpr double kOpenSigmaMm = 3.0;
/// So many pairs show whether what they hold to the skin has a shape.
constexpr std::size_t kShapePoints = 500;

/// The box that holds the skin, widened by how far a start may be off.
Eigen::AlignedBox3f reach_of(const DistanceField& field) {
  const FieldLevel& level = field.fine();
  const Eigen::Vector3f size_mm = static_cast<float>(FieldLevel::kBrickSide) * level.spacing_mm *
                                  Eigen::Vector3f(static_cast<float>(level.bricks[0]),
                                                  static_cast<float>(level.bricks[1]),
                                                  static_cast<float>(level.bricks[2]));
  const Eigen::Vector3f margin_mm = Eigen::Vector3f::Constant(kReachMm);
  return {level.origin_mm - margin_mm, level.origin_mm + size_mm + margin_mm};
}

std::size_t stride_for(std::size_t size, std::size_t wanted) {
  return std::max<std::size_t>(1, size / wanted);
}

/// Visits the points of some weight.
template <class Visit>
void for_each_point(const SensorPoints& points, const Visit& visit) {
  for (const auto& group : points.groups) {
    for (int i = 0; i < kLanes; ++i) {
      if (group.weight[i] > 0.0F) visit(Eigen::Vector3d(group.x[i], group.y[i], group.z[i]));
    }
  }
}

}  // namespace

FieldAlignment::FieldAlignment(const DistanceField& field,
                               const PointCloud& moving,
                               const Eigen::Isometry3d& start,
                               const PoseSpread& start_spread)
    : field_(field),
      num_moving_(moving.size()),
      start_(start),
      spread_(start_spread),
      pose_(start) {
  const auto kept = points_in_box(moving, start, reach_of(field));
  few_ = take_points(moving, kept, 1, stride_for(kept.size(), kFewPoints));
  all_ = take_points(moving, kept, 1, 1);
  const std::size_t runs_stride = stride_for(kept.size(), kRunPoints);
  if (runs_stride > 1) runs_ = take_points(moving, kept, kRunLength, runs_stride);
  double count = 0.0;
  double sum_sq_mm2 = 0.0;
  for_each_point(few_, [&](const Eigen::Vector3d& p) {
    count += 1.0;
    center_ += p;
  });
  if (count == 0.0) return;
  center_ /= count;
  for_each_point(few_,
                 [&](const Eigen::Vector3d& p) { sum_sq_mm2 += (p - center_).squaredNorm(); });
  radius_mm_ = std::max(1.0, std::sqrt(sum_sq_mm2 / count));
}

const SensorPoints& FieldAlignment::points_of(PointShare share) const {
  switch (share) {
    case PointShare::kFew:
      return few_;
    case PointShare::kRuns:
      // So few points that the runs are all of them.
      return runs_.size > 0 ? runs_ : all_;
    case PointShare::kAll:
      break;
  }
  return all_;
}

NormalEquations FieldAlignment::look(const Stage& stage) {
  const SensorPoints& points = points_of(stage.points);
  const FieldLevel& level = stage.fine ? field_.fine() : field_.coarse();
  const NormalEquations equations =
      linearizer_.linearize(level, points, pose_, pivot(), stage.rule);
  last_fit_ = {};
  if (points.sum_weights > 0.0) {
    last_fit_ = {.near_fraction = equations.sum_near_weights / points.sum_weights,
                 .below_fraction = equations.num_below / static_cast<double>(points.size),
                 .pair_fraction = equations.sum_weights / points.sum_weights};
  }
  return equations;
}

Vector6d FieldAlignment::start_information() const {
  Vector6d information;
  information.head<3>().setConstant(1.0 / (spread_.rotation_rad * spread_.rotation_rad));
  information.tail<3>().setConstant(1.0 / (spread_.shift_mm * spread_.shift_mm));
  return information;
}

/// One Gauss-Newton step; returns how far it moves the points, root mean square.
double FieldAlignment::step(const NormalEquations& equations, double stride) {
  const double share = stride / kCorrelatedReadings;
  const Vector6d held = start_information();
  // Where the pose is now, seen from the start: rotation about the pivot and the pivot's shift.
  const Eigen::AngleAxisd turned(Eigen::Matrix3d(pose_.linear() * start_.linear().transpose()));
  Vector6d from_start;
  from_start << turned.angle() * turned.axis(), pivot() - start_ * center_;
  Matrix6d information = share * equations.information;
  information.diagonal() += held;
  const Vector6d gradient = share * equations.gradient + held.cwiseProduct(from_start);
  const Vector6d twist = -information.ldlt().solve(gradient);
  const Eigen::Isometry3d turn = se3_exp((Vector6d() << twist.head<3>(), 0, 0, 0).finished());
  const Eigen::Vector3d about = pivot();
  pose_ = orthonormalized(Eigen::Translation3d(about + twist.tail<3>()) * turn *
                          Eigen::Translation3d(-about) * pose_);
  return std::hypot(twist.tail<3>().norm(), twist.head<3>().norm() * radius_mm_);
}

double FieldAlignment::distance_mm(const Eigen::Isometry3d& other) const {
  const Eigen::Matrix3d turn = pose_.linear() * other.linear().transpose();
  return std::hypot((pivot() - other * center_).norm(),
                    Eigen::AngleAxisd(turn).angle() * radius_mm_);
}

bool FieldAlignment::run(const Stage& stage, int max_iterations) {
  const auto stride = static_cast<double>(points_of(stage.points).stride);
  converged_ = false;
  for (int i = 0; i < std::min(stage.max_iterations, max_iterations); ++i) {
    const NormalEquations equations = look(stage);
    if (equations.num_pairs * stride < kMinPairs) return false;
    ++num_iterations_;
    converged_ = step(equations, stride) < stage.stop_step_mm;
    if (converged_) break;
  }
  return true;
}

bool FieldAlignment::run_all(std::span<const Stage> stages, int max_iterations) {
  for (const Stage& stage : stages) {
    if (!run(stage, max_iterations)) return false;
  }
  return true;
}

PoseFit FieldAlignment::fit(const Stage& stage) {
  static_cast<void>(look(stage));
  return last_fit_;
}

/// The eigenvectors of the information with small eigenvalues (Gelfand et al., "Geometrically
/// stable sampling for the ICP algorithm", 3DIM 2003; Zhang, Kaess & Singh, "On degeneracy of
/// optimization-based state estimation problems", ICRA 2016). Rotations are measured by how they
/// move the points, so that all directions are in mm.
std::vector<OpenDirection> FieldAlignment::open_directions(const NormalEquations& equations) const {
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(1.0 / radius_mm_), Eigen::Vector3d::Ones();
  const Matrix6d information = scale.asDiagonal() * equations.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information / kCorrelatedReadings);
  std::vector<OpenDirection> open;
  for (int i = 0; i < 6; ++i) {
    const double sigma_mm = 1.0 / std::sqrt(std::max(1e-12, eigen.eigenvalues()[i]));
    if (sigma_mm < kOpenSigmaMm) break;
    const Vector6d twist = scale.cwiseProduct(eigen.eigenvectors().col(i));
    open.push_back({twist.head<3>(), twist.tail<3>(), sigma_mm});
  }
  return open;
}

/// A plane or a sphere lies anywhere on a skin of its own shape, however well that fixes the pose.
bool FieldAlignment::has_shape() const {
  const auto points = linearizer_.some_pairs(kShapePoints);
  const auto depth_mm = static_cast<float>(std::max(0.0, center_.z()));
  const auto noise_mm = static_cast<double>(axial_noise_mm(depth_mm));
  return !points.empty() && !shape_without_pose(points, kShapeNoiseRatio * noise_mm);
}

RegistrationResult FieldAlignment::finish(const PairingRule& rule) {
  const NormalEquations equations = look({.rule = rule, .fine = true, .points = PointShare::kAll});
  RegistrationResult result;
  result.fixed_from_moving = pose_;
  result.num_iterations = num_iterations_;
  result.num_pairs = equations.num_pairs;
  if (num_moving_ > 0) {
    const auto size = static_cast<double>(num_moving_);
    result.explained_fraction = equations.num_near / size;
    result.seen_through_fraction = equations.num_below / size;
  }
  if (equations.sum_weights > 0.0) {
    result.rms_distance_mm = std::sqrt(equations.sum_weighted_sq / equations.sum_weights);
    const double mean_sq = equations.sum_weighted_sq / equations.num_pairs;
    result.information =
        PoseInformation{.matrix = equations.information,
                        .pivot_mm = pivot(),
                        .residual_scale = std::sqrt(mean_sq),
                        .unevenness = linearizer_.mean_sq_between_rows(all_) /
                                      (kRowsShare * std::max(mean_sq, kLeastMeanSq)),
                        .num_pairs = equations.num_pairs,
                        .unexplained_fraction = 1.0 - result.explained_fraction};
  }
  if (equations.num_pairs < kMinPairs) {
    result.status = RegistrationStatus::kTooFewPairs;
    return result;
  }
  result.open_directions = open_directions(equations);
  if (!result.open_directions.empty() || !has_shape()) {
    result.status = RegistrationStatus::kDegenerate;
  } else if (converged_) {
    result.status = RegistrationStatus::kConverged;
  }
  return result;
}

}  // namespace mor::internal
