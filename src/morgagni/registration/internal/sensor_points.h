// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/point_cloud.h"

namespace mor::internal {

/// A point of the moving surface with what the sensor's noise model says of it.
struct SensorPoint {
  Eigen::Vector3f point;   ///< mm, frame depth.
  Eigen::Vector3f normal;  ///< Towards the camera.
  float weight;            ///< 1 / variance of the distance measured along the normal, 1/mm^2.
};

/// Standard deviation of a Kinect's depth at distance `z_mm`: Nguyen, Izadi & Lovell, "Modeling
/// Kinect sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012.
[[nodiscard]] float axial_noise_mm(float z_mm);

/// Every `stride`-th point that can be trusted: those seen at a grazing angle are left out.
[[nodiscard]] std::vector<SensorPoint> weighted_points(const PointCloud& moving,
                                                       std::size_t stride);

}  // namespace mor::internal
