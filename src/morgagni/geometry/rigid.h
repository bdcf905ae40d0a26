// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"

namespace mor {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The angle of a rotation, in [0, pi].
[[nodiscard]] double rotation_angle_rad(const Eigen::Isometry3d& a_from_b);

/// How far `a_from_b` moves the point `p_b` differently from `a_from_b_other`, in mm.
[[nodiscard]] double displacement_mm(const Eigen::Isometry3d& a_from_b,
                                     const Eigen::Isometry3d& a_from_b_other,
                                     const Eigen::Vector3d& p_b);

/// Exponential map of SE(3): `twist` = (rotation vector in rad, translation in mm).
[[nodiscard]] Eigen::Isometry3d se3_exp(const Vector6d& twist);

/// Brings the rotation back to orthonormal after many products.
[[nodiscard]] Eigen::Isometry3d orthonormalized(const Eigen::Isometry3d& a_from_b);

/// The rigid motion that minimises the squared distances between paired points: Horn, "Closed-form
/// solution of absolute orientation using unit quaternions", JOSA A 1987. Never a reflection.
///
/// @param fixed, moving  N >= 3 pairs in mm, not on one line.
/// @return fixed_from_moving.
/// @errors kInvalidArgument: fewer than 3 pairs, different numbers, not finite, or collinear.
[[nodiscard]] Result<Eigen::Isometry3d> fit_rigid(std::span<const Eigen::Vector3d> fixed,
                                                  std::span<const Eigen::Vector3d> moving);

/// The same from sums: centroids and cross-covariance S = sum (moving - moving_centroid)
/// (fixed - fixed_centroid)^T. ICP accumulates these itself. Degenerate sums give any optimum.
[[nodiscard]] Eigen::Isometry3d fit_rigid(const Eigen::Vector3d& fixed_centroid,
                                          const Eigen::Vector3d& moving_centroid,
                                          const Eigen::Matrix3d& moving_fixed_covariance);

}  // namespace mor
