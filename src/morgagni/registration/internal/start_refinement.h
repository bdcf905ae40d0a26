// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/registration/distance_field.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {

/// How far a body on a plane may stray from lying on it as it did in the CT.
struct PlaneHold {
  Eigen::Vector3d up_ct = Eigen::Vector3d::UnitY();  ///< The plane's normal, frame ct.
  double height_sd_mm = 1.0;
  double tilt_sd_rad = 0.01;
};

/// One round of refinement.
struct RefinementRound {
  /// Tukey's scales: readings farther above the skin may be clutter, farther below it the pose is
  /// wrong there.
  float above_scale_mm = 10.0F;
  float below_scale_mm = 10.0F;
  bool fine = false;  ///< The field's level.
  int max_iterations = 5;
};

/// Brings a pose nearer by point-to-plane Gauss-Newton steps with Tukey's kernel, held on the plane
/// it started from. Unlike a fine registration it never looks far: what lies a towel's thickness
/// above the skin must not draw a pose that bare skin fixes.
///
/// @return The pose; as it was where too few points are near.
[[nodiscard]] Eigen::Isometry3d refine_on_plane(const DistanceField& field,
                                                const SensorPoints& moving,
                                                const Eigen::Isometry3d& ct_from_depth,
                                                const PlaneHold& hold,
                                                const RefinementRound& round);

}  // namespace mor::internal
