// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/field_registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/alignment_input.h"
#include "morgagni/registration/internal/normal_equations.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

/// Which of the points a stage uses.
enum class Share : std::uint8_t {
  kFew,   ///< Spread over all.
  kRuns,  ///< Runs of neighbours, for the look at rows.
  kAll,
};

/// One step of the annealing: a kernel, the field and the points it is used with.
struct Stage {
  PairingRule rule;
  bool fine = false;  ///< The field's level.
  Share points = Share::kFew;
  int max_iterations = 1;
  double stop_step_mm = 0.1;  ///< Stop when a step moves the points by less.
};

/// The few points of the early stages: about so many, and no fewer than every kMaxStride-th.
constexpr std::size_t kFewPoints = 800;
constexpr std::size_t kMaxStride = 8;
/// Runs of so many neighbours, about kRunPoints points in all.
constexpr std::size_t kRunLength = 24;
constexpr std::size_t kRunPoints = 3000;
constexpr std::size_t kMaxRunStride = 1000;

/// Above the skin the kernel is half as wide as below: what lies above may be clutter, what seems
/// to lie below is an error of the pose. Without this a towel on a head pulls it up.
constexpr std::array<Stage, 7> kStages = {{
    {{25.0F, 50.0F, 0.5F}, false, Share::kFew, 5, 2.0},
    {{12.5F, 25.0F, 0.5F}, false, Share::kFew, 5, 1.0},
    {{6.0F, 12.0F, 0.5F}, false, Share::kFew, 5, 0.5},
    {{6.0F, 12.0F, 0.5F}, true, Share::kFew, 3, 0.5},
    {{3.0F, 6.0F, 0.7F}, true, Share::kFew, 5, 0.1},
    {{6.0F, 6.0F, 0.7F, 3.0F}, true, Share::kRuns, 6, 0.05},
    {{6.0F, 6.0F, 0.7F, 3.0F}, true, Share::kAll, 2, 0.05},
}};
/// A tracked start enters the stages here.
constexpr std::size_t kTrackedEntry = 2;

/// Neighbouring readings err together (smooth sensor errors, the skin's own shape): so many of them
/// count as one when the data is weighed against the start.
constexpr double kCorrelatedReadings = 10.0;
constexpr int kMinPairs = 30;
/// A direction in which the data fixes the pose to no better than this is held by the start.
constexpr double kDegenerateSigmaMm = 1.0;
constexpr float kExplainedMm = 5.0F;
constexpr std::size_t kExplainedStride = 4;

/// How far the start may be off, as standard deviations: the Gauss-Newton steps keep to it in
/// directions that the data leaves open.
struct StartPrior {
  double shift_mm = 30.0;
  double rotation_rad = 20.0 * std::numbers::pi / 180.0;
};

StartPrior start_prior(StartQuality start) {
  if (start == StartQuality::kRough) return {};
  return {10.0, 5.0 * std::numbers::pi / 180.0};
}

std::size_t stride_for(const PointCloud& moving, std::size_t count, std::size_t limit) {
  return std::clamp<std::size_t>(moving.size() / count, 1, limit);
}

/// The working state of one alignment.
class Alignment {
 public:
  Alignment(const DistanceField& field,
            const PointCloud& moving,
            const Eigen::Isometry3d& init,
            StartQuality start)
      : field_(field),
        few_(take_points(moving, 1, stride_for(moving, kFewPoints, kMaxStride))),
        runs_(take_points(moving, kRunLength, stride_for(moving, kRunPoints, kMaxRunStride))),
        all_(take_points(moving, 1, 1)),
        init_(init),
        prior_(start_prior(start)),
        pose_(init) {
    double weight = 0.0;
    for (const auto& group : few_.groups) {
      for (int i = 0; i < kLanes; ++i) {
        if (group.weight[i] == 0.0F) continue;
        center_ += Eigen::Vector3f(group.x[i], group.y[i], group.z[i]).cast<double>();
        weight += 1.0;
      }
    }
    if (weight == 0.0) return;
    center_ /= weight;
    double sum_sq_mm2 = 0.0;
    for (const auto& group : few_.groups) {
      for (int i = 0; i < kLanes; ++i) {
        if (group.weight[i] == 0.0F) continue;
        sum_sq_mm2 += (Eigen::Vector3f(group.x[i], group.y[i], group.z[i]).cast<double>() - center_)
                          .squaredNorm();
      }
    }
    radius_mm_ = std::max(1.0, std::sqrt(sum_sq_mm2 / weight));
  }

  /// Runs one stage; false when too few points find the surface.
  [[nodiscard]] bool run(const Stage& stage, int max_iterations);
  [[nodiscard]] RegistrationResult finish(const PointCloud& moving) const;
  [[nodiscard]] int num_iterations() const { return num_iterations_; }

 private:
  [[nodiscard]] const SensorPoints& points_of(Share share) const;
  [[nodiscard]] double step(const NormalEquations& equations, double stride);
  [[nodiscard]] Vector6d prior_information() const;
  [[nodiscard]] bool is_degenerate() const;

  const DistanceField& field_;
  SensorPoints few_;
  SensorPoints runs_;
  SensorPoints all_;
  Eigen::Isometry3d init_;
  StartPrior prior_;
  Eigen::Isometry3d pose_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();  ///< Of the moving points.
  double radius_mm_ = 1.0;                            ///< Root mean square distance from it.
  Linearizer linearizer_;
  NormalEquations last_;
  double last_stride_ = 1.0;
  bool converged_ = false;
  int num_iterations_ = 0;
};

Vector6d Alignment::prior_information() const {
  Vector6d information;
  information.head<3>().setConstant(1.0 / (prior_.rotation_rad * prior_.rotation_rad));
  information.tail<3>().setConstant(1.0 / (prior_.shift_mm * prior_.shift_mm));
  return information;
}

/// One Gauss-Newton step; returns how far it moves the points, root mean square.
double Alignment::step(const NormalEquations& equations, double stride) {
  const Eigen::Vector3d pivot = pose_ * center_;
  const double share = stride / kCorrelatedReadings;
  const Vector6d prior = prior_information();
  // Where the pose is now, seen from the start: rotation about the pivot and the pivot's shift.
  const Eigen::AngleAxisd turned(Eigen::Matrix3d(pose_.linear() * init_.linear().transpose()));
  Vector6d from_start;
  from_start << turned.angle() * turned.axis(), pivot - init_ * center_;
  Matrix6d information = share * equations.information;
  information.diagonal() += prior;
  const Vector6d gradient = share * equations.gradient + prior.cwiseProduct(from_start);
  const Vector6d twist = -information.ldlt().solve(gradient);
  const Eigen::Isometry3d motion = se3_exp((Vector6d() << twist.head<3>(), 0, 0, 0).finished());
  pose_ =
      Eigen::Translation3d(pivot + twist.tail<3>()) * motion * Eigen::Translation3d(-pivot) * pose_;
  pose_ = orthonormalized(pose_);
  return std::hypot(twist.tail<3>().norm(), twist.head<3>().norm() * radius_mm_);
}

const SensorPoints& Alignment::points_of(Share share) const {
  switch (share) {
    case Share::kFew:
      return few_;
    case Share::kRuns:
      return runs_;
    case Share::kAll:
      break;
  }
  return all_;
}

bool Alignment::run(const Stage& stage, int max_iterations) {
  const SensorPoints& points = points_of(stage.points);
  const FieldLevel& level = stage.fine ? field_.fine() : field_.coarse();
  converged_ = false;
  for (int i = 0; i < stage.max_iterations && num_iterations_ < max_iterations; ++i) {
    last_ = linearizer_.linearize(level, points, pose_, pose_ * center_, stage.rule);
    last_stride_ = static_cast<double>(points.stride);
    if (last_.num_pairs * last_stride_ < kMinPairs) return false;
    ++num_iterations_;
    converged_ = step(last_, last_stride_) < stage.stop_step_mm;
    if (converged_) break;
  }
  return true;
}

/// Whether some direction is left to the start. Rotations are measured by how they move the points.
bool Alignment::is_degenerate() const {
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(1.0 / radius_mm_), Eigen::Vector3d::Ones();
  const Matrix6d information = last_stride_ / kCorrelatedReadings *
                               (scale.asDiagonal() * last_.information * scale.asDiagonal());
  const double weakest =
      Eigen::SelfAdjointEigenSolver<Matrix6d>(information, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return weakest * kDegenerateSigmaMm * kDegenerateSigmaMm < 1.0;
}

RegistrationResult Alignment::finish(const PointCloud& moving) const {
  RegistrationResult result;
  result.fixed_from_moving = pose_;
  result.num_iterations = num_iterations_;
  result.num_pairs = last_.num_pairs;
  if (last_.sum_weights > 0.0) {
    result.rms_distance_mm = std::sqrt(last_.sum_weighted_sq / last_.sum_weights);
    result.information = PoseInformation{
        .matrix = last_stride_ * last_.information,
        .pivot_mm = pose_ * center_,
        .residual_scale = std::sqrt(last_.sum_weighted_sq / static_cast<double>(last_.num_pairs)),
        .num_pairs = last_.num_pairs};
  }
  if (!moving.empty())
    result.explained_fraction =
        static_cast<double>(last_.num_near) / (static_cast<double>(moving.size()) / last_stride_);
  if (last_.num_pairs * last_stride_ < kMinPairs) {
    result.status = RegistrationStatus::kTooFewPairs;
  } else if (is_degenerate()) {
    result.status = RegistrationStatus::kDegenerate;
  } else if (converged_) {
    result.status = RegistrationStatus::kConverged;
  }
  return result;
}

}  // namespace

FieldRegistration::FieldRegistration(std::shared_ptr<const FixedSurface> fixed,
                                     const RegistrationOptions& options)
    : fixed_(std::move(fixed)), options_(options) {}

Result<RegistrationResult> FieldRegistration::align(const PointCloud& moving,
                                                    const Eigen::Isometry3d& fixed_from_moving_init,
                                                    StartQuality start) const {
  MOR_CHECK(check_alignment_input(moving, fixed_from_moving_init, /*needs_normals=*/true));
  Alignment alignment(fixed_->field, moving, fixed_from_moving_init, start);
  const std::size_t entry = start == StartQuality::kTracked ? kTrackedEntry : 0;
  for (std::size_t i = entry; i < kStages.size(); ++i) {
    if (!alignment.run(kStages[i], options_.max_iterations)) break;
  }
  return alignment.finish(moving);
}

}  // namespace mor::internal
