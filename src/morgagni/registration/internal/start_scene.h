// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/point_cloud.h"
#include "morgagni/registration/internal/sensor_points.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_planes.h"

namespace mor::internal {

/// What stands on a plane of the picture, as points to be found on the CT's body.
struct StartScene {
  StartPlane plane;
  /// z up from the plane, origin below the points' middle.
  Eigen::Isometry3d table_from_depth = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector3f> search_points;  ///< Few, even over the surface, frame table.
  std::vector<Eigen::Vector3f> dense_points;   ///< Thousands, frame table.
  PointCloud full;                             ///< Some thousands, frame depth, with normals.
  SensorPoints even;                           ///< The same, each the mean around it.
};

/// @param body_height_mm  What rises much higher above the plane is not the body.
/// @param body_extent_mm  The body's largest side: sets how dense the points are.
[[nodiscard]] StartScene make_scene(const StartPicture& picture,
                                    const StartPlane& plane,
                                    float body_height_mm,
                                    float body_extent_mm);

/// What is seen and lies in none of the large planes, spread evenly, frame depth.
[[nodiscard]] PointCloud standing_points(const StartPicture& picture,
                                         const std::vector<StartPlane>& planes,
                                         float body_extent_mm);

}  // namespace mor::internal
