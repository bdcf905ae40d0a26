// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/point_cloud.h"
#include "morgagni/registration/internal/lanes.h"

namespace mor::internal {

/// Points of the moving surface with what the sensor's noise model says of them. Frame depth, mm.
struct PointLanes {
  Lanes x, y, z;
  Lanes normal_x, normal_y, normal_z;  ///< Towards the camera.
  /// 1 / variance of the distance measured along the normal, 1/mm^2. 0: not to be trusted, as it is
  /// seen at a grazing angle, or no point at all.
  Lanes weight;
};

/// A row of points reaches so far to either side of one.
inline constexpr std::size_t kRowReach = 4;

/// The points before and after a point in the picture's row that are averaged with it.
struct RowReach {
  std::uint8_t before = 0;
  std::uint8_t after = 0;
};

/// Some points of the moving surface, in the picture's order.
struct SensorPoints {
  std::vector<PointLanes> groups;  ///< The last one is filled up with points of no weight.
  std::vector<RowReach> rows;      ///< One a point.
  std::size_t size = 0;
  std::size_t stride = 1;    ///< Each stands for so many readings.
  double sum_weights = 0.0;  ///< Of all.
};

/// Standard deviation of a Kinect's depth at distance `z_mm`: Nguyen, Izadi & Lovell, "Modeling
/// Kinect sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012.
[[nodiscard]] float axial_noise_mm(float z_mm);

/// Those points of the moving surface that a pose puts into a box of the frame fixed.
[[nodiscard]] std::vector<std::uint32_t> points_in_box(const PointCloud& moving,
                                                       const Eigen::Isometry3d& fixed_from_moving,
                                                       const Eigen::AlignedBox3f& box_mm);

/// Takes runs of `run_length` of the points `kept`, and of the runs every `stride`-th.
[[nodiscard]] SensorPoints take_points(const PointCloud& moving,
                                       std::span<const std::uint32_t> kept,
                                       std::size_t run_length,
                                       std::size_t stride);
/// Takes all of them.
[[nodiscard]] SensorPoints take_points(const PointCloud& moving);

}  // namespace mor::internal
