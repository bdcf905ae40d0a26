// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/rigid.h"

#include <Eigen/Eigenvalues>
#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

/// Points whose second-largest spread is below this share of the largest lie on a line.
constexpr double kCollinearRatio = 1e-6;

Eigen::Vector3d centroid(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

bool are_collinear(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& center) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& point : points) scatter += (point - center) * (point - center).transpose();
  const Eigen::Vector3d spread =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  return spread[1] <= kCollinearRatio * spread[2];
}

}  // namespace

double rotation_angle_rad(const Eigen::Isometry3d& a_from_b) {
  return Eigen::AngleAxisd(a_from_b.linear()).angle();
}

double displacement_mm(const Eigen::Isometry3d& a_from_b,
                       const Eigen::Isometry3d& a_from_b_other,
                       const Eigen::Vector3d& p_b) {
  return (a_from_b * p_b - a_from_b_other * p_b).norm();
}

Eigen::Isometry3d se3_exp(const Vector6d& twist) {
  const Eigen::Vector3d rotation = twist.head<3>();
  const double angle = rotation.norm();
  Eigen::Matrix3d cross;
  cross << 0.0, -rotation.z(), rotation.y(), rotation.z(), 0.0, -rotation.x(), -rotation.y(),
      rotation.x(), 0.0;
  // (1 - cos a) / a^2 and (a - sin a) / a^3, by their series where the quotients lose digits.
  const bool small = angle < 1e-4;
  const double b = small ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double c = small ? 1.0 / 6.0 - angle * angle / 120.0
                         : (angle - std::sin(angle)) / (angle * angle * angle);
  const double a = small ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = Eigen::Matrix3d::Identity() + a * cross + b * cross * cross;
  result.translation() =
      (Eigen::Matrix3d::Identity() + b * cross + c * cross * cross) * twist.tail<3>();
  return result;
}

Eigen::Isometry3d orthonormalized(const Eigen::Isometry3d& a_from_b) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = Eigen::Quaterniond(a_from_b.linear()).normalized().toRotationMatrix();
  result.translation() = a_from_b.translation();
  return result;
}

Result<Eigen::Isometry3d> fit_rigid(std::span<const Eigen::Vector3d> fixed,
                                    std::span<const Eigen::Vector3d> moving) {
  if (fixed.size() != moving.size() || fixed.size() < 3) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("a rigid fit needs at least 3 pairs of points, got {} and {}",
                                  fixed.size(),
                                  moving.size()));
  }
  const Eigen::Vector3d fixed_centroid = centroid(fixed);
  const Eigen::Vector3d moving_centroid = centroid(moving);
  if (!fixed_centroid.allFinite() || !moving_centroid.allFinite()) {
    return make_error(ErrorCode::kInvalidArgument, "a rigid fit needs finite points");
  }
  if (are_collinear(fixed, fixed_centroid) || are_collinear(moving, moving_centroid)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the points lie on one line, which leaves the rotation about it open: choose "
                      "one to the side of it");
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    covariance += (moving[i] - moving_centroid) * (fixed[i] - fixed_centroid).transpose();
  }
  return fit_rigid(fixed_centroid, moving_centroid, covariance);
}

Eigen::Isometry3d fit_rigid(const Eigen::Vector3d& fixed_centroid,
                            const Eigen::Vector3d& moving_centroid,
                            const Eigen::Matrix3d& s) {
  // Horn 1987, section 4.A: the quaternion is the eigenvector of N's largest eigenvalue.
  Eigen::Matrix4d n;
  n << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),
      s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),
      s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1),
      s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), s(2, 2) - s(0, 0) - s(1, 1);
  const Eigen::Vector4d q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(n).eigenvectors().col(3);
  Eigen::Isometry3d fixed_from_moving = Eigen::Isometry3d::Identity();
  fixed_from_moving.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  fixed_from_moving.translation() = fixed_centroid - fixed_from_moving.linear() * moving_centroid;
  return fixed_from_moving;
}

}  // namespace mor
