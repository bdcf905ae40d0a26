// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_refinement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/normal_equations.h"

namespace mor::internal {
namespace {

constexpr float kLeastNormalCosine = 0.6F;
/// So many neighbouring readings count as one against the hold.
constexpr double kCorrelatedReadings = 10.0;
constexpr int kLeastPairs = 15;
constexpr double kStopMm = 0.05;

/// Information of the hold: on rotations that tilt the plane and on the height.
Matrix6d hold_information(const PlaneHold& hold) {
  const Eigen::Matrix3d along = hold.up_ct * hold.up_ct.transpose();
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>() =
      (Eigen::Matrix3d::Identity() - along) / (hold.tilt_sd_rad * hold.tilt_sd_rad);
  information.bottomRightCorner<3, 3>() = along / (hold.height_sd_mm * hold.height_sd_mm);
  // Nothing else is held: just enough to solve for directions without any pair.
  information.diagonal().head<3>().array() += 1e-2;
  information.diagonal().tail<3>().array() += 1e-6;
  return information;
}

}  // namespace

Eigen::Isometry3d refine_on_plane(const DistanceField& field,
                                  const SensorPoints& moving,
                                  const Eigen::Isometry3d& ct_from_depth,
                                  const PlaneHold& hold,
                                  const RefinementRound& round) {
  const FieldLevel& level = round.fine ? field.fine() : field.coarse();
  const Matrix6d held = hold_information(hold);
  // About the body's own middle, so that a turn is not a shift.
  const Eigen::Vector3d pivot =
      (level.origin_mm + 0.5F * level.spacing_mm * static_cast<float>(FieldLevel::kBrickSide) *
                             Eigen::Vector3f(static_cast<float>(level.bricks[0]),
                                             static_cast<float>(level.bricks[1]),
                                             static_cast<float>(level.bricks[2])))
          .cast<double>();
  const double radius_mm = 0.5 * static_cast<double>(level.spacing_mm) * FieldLevel::kBrickSide *
                           *std::max_element(level.bricks.begin(), level.bricks.end());
  Eigen::Isometry3d pose = ct_from_depth;
  const Eigen::Vector3d pivot_in_depth = ct_from_depth.inverse() * pivot;
  const PairingRule rule = {.above_scale_mm = round.above_scale_mm,
                            .below_scale_mm = round.below_scale_mm,
                            .min_normal_cosine = kLeastNormalCosine};
  Linearizer linearizer;
  for (int i = 0; i < round.max_iterations; ++i) {
    const NormalEquations data = linearizer.linearize(level, moving, pose, pivot, rule);
    if (data.num_pairs < kLeastPairs) return pose;
    const Eigen::AngleAxisd turned(
        Eigen::Matrix3d(pose.linear() * ct_from_depth.linear().transpose()));
    Vector6d from_start;
    from_start << turned.angle() * turned.axis(), pose * pivot_in_depth - pivot;
    const Matrix6d information = data.information / kCorrelatedReadings + held;
    const Vector6d gradient = data.gradient / kCorrelatedReadings + held * from_start;
    const Vector6d twist = -information.ldlt().solve(gradient);
    const Eigen::Isometry3d turn = se3_exp((Vector6d() << twist.head<3>(), 0, 0, 0).finished());
    pose = orthonormalized(Eigen::Translation3d(pivot + twist.tail<3>()) * turn *
                           Eigen::Translation3d(-pivot) * pose);
    if (std::hypot(twist.tail<3>().norm(), radius_mm * twist.head<3>().norm()) < kStopMm) break;
  }
  return pose;
}

}  // namespace mor::internal
