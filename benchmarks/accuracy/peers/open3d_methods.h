// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <open3d/geometry/KDTreeFlann.h>
#include <open3d/geometry/PointCloud.h>

#include "answering.h"

namespace mor::peers {

/// The fixed side, ready for every Open3D method.
struct Open3dFixed {
  Open3dFixed(const TriangleMesh& skin, bool starts_are_tracked);

  open3d::geometry::PointCloud cloud;  ///< With normals, and the covariances that they imply.
  open3d::geometry::KDTreeFlann tree;
  bool starts_are_tracked = false;
};

/// One gate of a coarse-to-fine ICP.
struct Open3dLevel {
  double gate_mm = 0.0;          ///< Pairs farther apart are dropped.
  double kernel_mm = 0.0;        ///< Tukey's scale, of the distances to planes.
  std::size_t point_stride = 1;  ///< Every so many moving points.
  int max_iterations = 30;
  double stop_rmse_mm = 1e-3;  ///< Stop when a step changes the residual by less, ...
  double stop_fitness = 1e-4;  ///< ... and the share of points with a pair.
};

enum class Open3dEstimator : std::uint8_t { kPointToPoint, kPointToPlane, kGeneralized };

[[nodiscard]] open3d::geometry::PointCloud to_open3d(const TriangleMesh& mesh);

/// Level by level. The loop is that of open3d::pipelines::registration::RegistrationICP, with its
/// estimators, but for the fixed side's tree, which that function builds anew in each call.
/// @param moving  With normals for kGeneralized.
[[nodiscard]] Eigen::Isometry3d align_coarse_to_fine(const Open3dFixed& fixed,
                                                     const open3d::geometry::PointCloud& moving,
                                                     Eigen::Isometry3d fixed_from_moving,
                                                     Open3dEstimator estimator,
                                                     const std::vector<Open3dLevel>& levels);

/// For a start up to 30 mm / 20 degrees off; a tracked one (5 mm / 2 degrees) skips the first two.
[[nodiscard]] std::vector<Open3dLevel> open3d_levels(Open3dEstimator estimator, bool is_tracked);

/// "open3d-point-to-plane", "open3d-generalized", "open3d-point-to-point",
/// "open3d-registration-icp" (point-to-plane by the library's whole function).
void add_open3d_icp(const std::shared_ptr<const Open3dFixed>& fixed, MethodMakers& makers);
/// "open3d-fpfh-ransac", "open3d-fpfh-fgr".
void add_open3d_global(const std::shared_ptr<const Open3dFixed>& fixed, MethodMakers& makers);

}  // namespace mor::peers
