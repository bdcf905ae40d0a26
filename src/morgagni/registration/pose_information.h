// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace mor {

/// What the data say of a pose: the quadratic form of a registration's weighted squared distances
/// about it. Its inverse is the pose's covariance as far as the noise model is right and the
/// readings independent.
struct PoseInformation {
  /// Of (rotation about the pivot in rad, shift in mm), frame fixed: sum w J^T J, w in 1/mm^2 from
  /// the sensor's noise model and the robust kernel.
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();  ///< Frame fixed.
  /// Root mean square of the distances over their expected standard deviations: 1 where the noise
  /// model explains the residual.
  double residual_scale = 0.0;
  /// How far apart the mean distances of neighbouring rows of points are, as a variance over that of
  /// the points' own noise: 1 to 2 where they follow the surface, more where they cross it in
  /// waves. A sensor's slow error does not show in it. 0 where there are no rows.
  double unevenness = 0.0;
  int num_pairs = 0;
  /// Share of all moving points that is not near the surface, 0..1: clutter, some of which is
  /// mistaken for the surface where it touches it.
  double unexplained_fraction = 0.0;
};

}  // namespace mor
