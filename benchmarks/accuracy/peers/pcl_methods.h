// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include "answering.h"

namespace mor::peers {

using PclPoint = pcl::PointNormal;
using PclCloud = pcl::PointCloud<PclPoint>;
using PclTree = pcl::search::KdTree<PclPoint>;
using PclCovariances = std::vector<Eigen::Matrix3d, Eigen::aligned_allocator<Eigen::Matrix3d>>;

/// The fixed side, ready for every PCL method.
struct PclFixed {
  PclFixed(const TriangleMesh& skin, bool starts_are_tracked);

  PclCloud::Ptr cloud;
  PclTree::Ptr tree;
  pcl::shared_ptr<PclCovariances> covariances;  ///< That the normals imply.
  bool starts_are_tracked = false;
};

/// One gate of a coarse-to-fine ICP.
struct PclLevel {
  double gate_mm = 0.0;          ///< Pairs farther apart are dropped.
  std::size_t point_stride = 1;  ///< Every so many moving points.
  int max_iterations = 30;
  double stop_mm = 0.01;  ///< Stop when a step shifts by less and turns by less than stop_rad.
  double stop_rad = 1e-4;
};

/// For a start up to 30 mm / 20 degrees off; a tracked one (5 mm / 2 degrees) skips the first two.
[[nodiscard]] std::vector<PclLevel> pcl_levels(bool is_tracked);

[[nodiscard]] PclCloud::Ptr to_pcl(const TriangleMesh& mesh);
[[nodiscard]] PclCloud::Ptr every_nth_point(const PclCloud& cloud, std::size_t stride);
[[nodiscard]] Eigen::Isometry3d to_isometry(const Eigen::Matrix4d& matrix);

struct PclIcpRules {
  bool to_planes = true;       ///< Point-to-plane by linear least squares, or Besl and McKay.
  bool same_facing = false;    ///< Normals of a pair at most 45 degrees apart.
  double kept_fraction = 1.0;  ///< Of the closest pairs; below 1 a trimmed ICP.
};

/// Level by level with pcl::IterativeClosestPointWithNormals.
[[nodiscard]] Eigen::Isometry3d align_pcl_icp(const PclFixed& fixed,
                                              const PclCloud& moving,
                                              Eigen::Isometry3d fixed_from_moving,
                                              const PclIcpRules& rules,
                                              const std::vector<PclLevel>& levels);

/// "pcl-icp", "pcl-point-to-plane", "pcl-point-to-plane-trimmed", "pcl-trimmed-icp".
void add_pcl_icp(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers);
/// "pcl-gicp", "pcl-ndt".
void add_pcl_distributions(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers);
/// "pcl-sac-ia", "pcl-prerejective".
void add_pcl_global(const std::shared_ptr<const PclFixed>& fixed, MethodMakers& makers);

}  // namespace mor::peers
