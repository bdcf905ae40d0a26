// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/error_bound.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mor {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A direction that is open: the readings fix it to no better than this. Rotations are measured at
/// kLeverMm from the pivot.
constexpr double kOpenSigmaMm = 50.0;
constexpr double kLeverMm = 100.0;

/// 95 % quantile of chi^2 for 1 to 3 degrees of freedom, fractions between: the parabola through
/// the exact values is right to 0.4 %.
double chi_square_95(double degrees) {
  constexpr std::array<double, 3> kExact = {3.841459, 5.991465, 7.814728};
  const double t = std::clamp(degrees, 1.0, 3.0) - 1.0;
  const double first = kExact[1] - kExact[0];
  const double second = kExact[2] - 2.0 * kExact[1] + kExact[0];
  return kExact[0] + t * first + 0.5 * t * (t - 1.0) * second;
}

}  // namespace

BoundCalibration default_bound_calibration() {
  return {.correlated_readings = 1.7,
          .least_residual_scale = 0.37,
          .clutter_growth = 0.5,
          .systematic_mm = 0.0,
          .floor_mm = 0.0};
}

BoundCalibration with_sensor_bias(const BoundCalibration& calibration,
                                  double sensor_bias_mm,
                                  double distance_mm) {
  constexpr double kSharedByAll = 0.12;
  constexpr double kGrowsFromMm = 800.0;
  const double there_mm = sensor_bias_mm * std::max(1.0, distance_mm / kGrowsFromMm);
  BoundCalibration result = calibration;
  result.systematic_mm = std::hypot(calibration.systematic_mm, kSharedByAll * there_mm);
  return result;
}

std::optional<PoseCovariance> pose_covariance(const PoseInformation& information,
                                              const BoundCalibration& calibration) {
  // Scaled so that rotations and shifts are of one size: lengths at the lever.
  Eigen::Matrix<double, 6, 1> scale;
  scale << Eigen::Vector3d::Constant(1.0 / kLeverMm), Eigen::Vector3d::Ones();
  const Matrix6d scaled = scale.asDiagonal() * information.matrix * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scaled);
  const double sigma = std::max(calibration.least_residual_scale, information.residual_scale);
  const double sum_weights = information.matrix.diagonal().tail<3>().sum();
  const double clutter = 1.0 + calibration.clutter_growth * information.unexplained_fraction;
  const double variance = sigma * sigma * calibration.correlated_readings * clutter +
                          sum_weights * calibration.systematic_mm * calibration.systematic_mm;
  const double weakest = eigen.eigenvalues()[0];
  // Written so that NaN is open.
  if (!(weakest * kOpenSigmaMm * kOpenSigmaMm > variance)) return std::nullopt;
  PoseCovariance pose;
  pose.pivot_mm = information.pivot_mm;
  pose.matrix = variance * (scale.asDiagonal() * eigen.eigenvectors() *
                            eigen.eigenvalues().cwiseInverse().asDiagonal() *
                            eigen.eigenvectors().transpose() * scale.asDiagonal());
  pose.matrix.diagonal().tail<3>().array() += calibration.floor_mm * calibration.floor_mm;
  return pose;
}

Eigen::Matrix3d target_covariance_mm2(const PoseCovariance& pose,
                                      const Eigen::Vector3d& ct_point_mm) {
  const Eigen::Vector3d lever = ct_point_mm - pose.pivot_mm;
  Eigen::Matrix<double, 3, 6> jacobian;
  // A rotation w moves the point by w x lever = -lever x w.
  jacobian << 0.0, lever.z(), -lever.y(), 1.0, 0.0, 0.0,  //
      -lever.z(), 0.0, lever.x(), 0.0, 1.0, 0.0,          //
      lever.y(), -lever.x(), 0.0, 0.0, 0.0, 1.0;
  return jacobian * pose.matrix * jacobian.transpose();
}

double error_bound_mm(const PoseCovariance& pose, const Eigen::Vector3d& ct_point_mm) {
  const Eigen::Matrix3d covariance = target_covariance_mm2(pose, ct_point_mm);
  // Sum of the eigenvalues and of their squares.
  const double sum = covariance.trace();
  const double sum_sq = covariance.squaredNorm();
  if (!(sum > 0.0)) return 0.0;
  return std::sqrt(sum_sq / sum * chi_square_95(sum * sum / sum_sq));
}

}  // namespace mor
