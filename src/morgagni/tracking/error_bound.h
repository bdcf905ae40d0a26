// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "morgagni/registration/pose_information.h"

namespace mor {

/// How sure a pose is, as a covariance of (rotation about the pivot in rad, shift in mm), frame ct.
struct PoseCovariance {
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();
};

/// What the inverse of the information leaves out. Fitted on simulated runs by `morgagni evaluate
/// bound` (docs/error-bound.md).
struct BoundCalibration {
  /// Readings err together with their neighbours: so many of them count as one. > 0.
  double correlated_readings = 1.0;
  /// A residual over the noise of single readings that is smaller is taken as this: points are
  /// means of some readings and have two fifths of it. > 0.
  double least_residual_scale = 1.0;
  /// By how much the variance grows, times the share of the points that is not explained: clutter
  /// that touches the skin is mistaken for it in part. >= 0.
  double clutter_growth = 0.0;
  /// Standard deviation of an error that all readings share in part: the sensor's, the skin's, the
  /// field's. No number of readings averages it out. >= 0.
  double systematic_mm = 0.0;
  double floor_mm = 0.0;  ///< Standard deviation of the shift, each direction, at least. >= 0.
};

/// Calibrated on seeds 2000 to 2059 and 6000 to 6059.
[[nodiscard]] BoundCalibration default_bound_calibration();

/// The same for a sensor whose depth errs systematically, smoothly over the picture, by so much
/// (root mean square) up to 0.8 m, and beyond that in proportion to the distance: like an error of
/// 0.12 of that which all readings share, found by the same study.
/// @param distance_mm  Of the skin seen from the camera.
[[nodiscard]] BoundCalibration with_sensor_bias(const BoundCalibration& calibration,
                                                double sensor_bias_mm,
                                                double distance_mm);

/// (k sigma^2 (1 + g u) + W b^2) M^-1 + floor, where M is the information, k the readings that
/// count as one, sigma the residual over the expected noise, not below the least, u the share of
/// the points that is not explained and g what it adds, W the sum of the readings' weights (the
/// trace of M's shift part: normals are unit vectors) and b the systematic error. W M^-1 is the
/// geometry alone: how a unit error along the normals reaches the pose.
/// @return None where the data leaves a direction open: there is no bound then.
[[nodiscard]] std::optional<PoseCovariance> pose_covariance(
    const PoseInformation& information,
    const BoundCalibration& calibration = default_bound_calibration());

/// Covariance in mm^2 of where the pose puts a CT point: J C J^T with J = [-(p - pivot)x, I].
[[nodiscard]] Eigen::Matrix3d target_covariance_mm2(const PoseCovariance& pose,
                                                    const Eigen::Vector3d& ct_point_mm);

/// The error that 95 % of the cases stay below at a CT point: the 95 % quantile of the norm of a
/// Gaussian with the target's covariance. Its square is a sum of l_i chi^2_1 over the eigenvalues
/// l_i, taken as c chi^2_f with the same mean and variance (Satterthwaite, Biometrics Bulletin 2,
/// 1946): exact where all eigenvalues that are not 0 are equal, right to 1 % otherwise.
[[nodiscard]] double error_bound_mm(const PoseCovariance& pose, const Eigen::Vector3d& ct_point_mm);

}  // namespace mor
