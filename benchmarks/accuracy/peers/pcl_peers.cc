// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// PCL on a set of problems: pcl_peers PROBLEMS, see answering.h.
#include <cstdio>

#include <pcl/console/print.h>
#include <pcl/features/from_meshes.h>

#include "pcl_methods.h"

namespace mor::peers {

PclFixed::PclFixed(const TriangleMesh& skin, bool are_tracked)
    : cloud(to_pcl(skin)),
      tree(pcl::make_shared<PclTree>()),
      covariances(pcl::make_shared<PclCovariances>()),
      starts_are_tracked(are_tracked) {
  tree->setInputCloud(cloud);
  pcl::features::computeApproximateCovariances(*cloud, *cloud, *covariances);
}

std::vector<PclLevel> pcl_levels(bool is_tracked) {
  std::vector<PclLevel> levels;
  if (!is_tracked) levels = {{50.0, 8, 15, 0.5, 5e-3}, {25.0, 8, 15, 0.5, 5e-3}};
  levels.push_back({12.0, 4, 15, 0.1, 1e-3});
  levels.push_back({6.0, 1, 30, 0.01, 1e-4});
  return levels;
}

PclCloud::Ptr to_pcl(const TriangleMesh& mesh) {
  auto cloud = pcl::make_shared<PclCloud>();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    PclPoint point;
    point.getVector3fMap() = mesh.vertices[i];
    point.getNormalVector3fMap() = mesh.normals[i];
    cloud->push_back(point);
  }
  return cloud;
}

PclCloud::Ptr every_nth_point(const PclCloud& cloud, std::size_t stride) {
  auto part = pcl::make_shared<PclCloud>();
  part->reserve(cloud.size() / stride + 1);
  for (std::size_t i = 0; i < cloud.size(); i += stride) part->push_back(cloud[i]);
  return part;
}

Eigen::Isometry3d to_isometry(const Eigen::Matrix4d& matrix) {
  Eigen::Isometry3d pose(matrix);
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return pose;
}

}  // namespace mor::peers

int main(int argc, char** argv) {
  using namespace mor::peers;
  const auto problems = read_problems(argc > 1 ? argv[1] : "");
  if (!problems) {
    std::fprintf(stderr, "pcl_peers: %s\n", problems.error().message.c_str());
    return 1;
  }
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  const auto fixed = std::make_shared<const PclFixed>(problems->fixed, problems->is_tracked);
  MethodMakers makers;
  add_pcl_icp(fixed, makers);
  add_pcl_distributions(fixed, makers);
  add_pcl_global(fixed, makers);
  return answer_requests(*problems, makers);
}
