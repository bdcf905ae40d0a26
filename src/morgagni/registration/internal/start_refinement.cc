// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_refinement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr float kLeastNormalCosine = 0.6F;
constexpr float kGrazingCosine = 0.2F;
/// So many neighbouring readings count as one against the hold.
constexpr double kCorrelatedReadings = 10.0;
constexpr int kLeastPairs = 15;
constexpr double kStopMm = 0.05;

/// sum w (d + J twist)^2 about a pose, twist = (rotation about the pivot, shift), frame ct.
struct Quadratic {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  int num_pairs = 0;
};

Quadratic linearize(const FieldLevel& level,
                    const PointCloud& moving,
                    const Eigen::Isometry3f& ct_from_depth,
                    const Eigen::Vector3f& pivot,
                    const RefinementRound& round) {
  Quadratic sum;
  const Eigen::Matrix3f rotation = ct_from_depth.linear();
  const Eigen::Vector3f camera = ct_from_depth.translation();
  FieldSample sample;
  Eigen::Matrix<float, 6, 1> row;
  Eigen::Matrix<float, 6, 6> information = Eigen::Matrix<float, 6, 6>::Zero();
  Eigen::Matrix<float, 6, 1> gradient = Eigen::Matrix<float, 6, 1>::Zero();
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const Eigen::Vector3f p = rotation * moving.points[i] + camera;
    if (!DistanceField::look_up(level, p, sample)) continue;
    const float scale_mm = sample.distance_mm > 0.0F ? round.above_scale_mm : round.below_scale_mm;
    const float ratio = sample.distance_mm / scale_mm;
    if (std::abs(ratio) >= 1.0F) continue;
    const Eigen::Vector3f to_camera = camera - p;
    if (sample.normal.dot(to_camera) < kGrazingCosine * to_camera.norm()) continue;
    if (sample.normal.dot(rotation * moving.normals[i]) < kLeastNormalCosine) continue;
    const float noise_mm = axial_noise_mm(moving.points[i].z());
    const float rest = 1.0F - ratio * ratio;
    const float weight = rest * rest / (noise_mm * noise_mm);
    row.head<3>() = (p - pivot).cross(sample.normal);
    row.tail<3>() = sample.normal;
    information += weight * row * row.transpose();
    gradient += weight * sample.distance_mm * row;
    ++sum.num_pairs;
  }
  sum.information = information.cast<double>();
  sum.gradient = gradient.cast<double>();
  return sum;
}

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
                                  const PointCloud& moving,
                                  const Eigen::Isometry3d& ct_from_depth,
                                  const PlaneHold& hold,
                                  const RefinementRound& round) {
  const FieldLevel& level = round.fine ? field.fine() : field.coarse();
  const Matrix6d held = hold_information(hold);
  // About the body's own middle, so that a turn is not a shift.
  const Eigen::Vector3f pivot_f =
      level.origin_mm + 0.5F * level.spacing_mm * static_cast<float>(FieldLevel::kBrickSide) *
                            Eigen::Vector3f(static_cast<float>(level.bricks[0]),
                                            static_cast<float>(level.bricks[1]),
                                            static_cast<float>(level.bricks[2]));
  const Eigen::Vector3d pivot = pivot_f.cast<double>();
  const double radius_mm = 0.5 * static_cast<double>(level.spacing_mm) * FieldLevel::kBrickSide *
                           *std::max_element(level.bricks.begin(), level.bricks.end());
  Eigen::Isometry3d pose = ct_from_depth;
  const Eigen::Vector3d pivot_in_depth = ct_from_depth.inverse() * pivot;
  for (int i = 0; i < round.max_iterations; ++i) {
    const Quadratic data = linearize(level, moving, pose.cast<float>(), pivot_f, round);
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
