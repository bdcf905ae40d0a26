// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/icp_surface.h"

namespace mor::internal {

PairMetric metric_of(RegistrationMethod method) {
  return method == RegistrationMethod::kAnisotropicIcp ||
                 method == RegistrationMethod::kTrimmedAnisotropicIcp
             ? PairMetric::kWeighted
             : PairMetric::kEuclidean;
}

namespace {

std::vector<float> largest_variances_below(const BalancedKdTree& tree,
                                           std::span<const SkinError> errors) {
  std::vector<Eigen::Vector3f> below(errors.size());
  std::vector<float> largest_mm2(errors.size());
  for (std::size_t node = errors.size(); node-- > 0;) {
    below[node] = errors[node].sideways_mm2 - errors[node].along_normal_mm.cwiseAbs2().array();
    for (std::size_t child = 2 * node + 1; child <= 2 * node + 2 && child < errors.size();
         ++child) {
      below[node] = below[node].cwiseMax(below[child]);
    }
    largest_mm2[node] = below[node][tree.axis[node]];
  }
  return largest_mm2;
}

}  // namespace

IcpSurface::IcpSurface(const TriangleMesh& mesh, PairMetric pair_metric)
    : metric(pair_metric), center(mesh.bounds().center().cast<double>()), tree(mesh.vertices) {
  points.reserve(mesh.vertices.size());
  normals.reserve(mesh.vertices.size());
  for (const auto idx : tree.order) {
    points.emplace_back((mesh.vertices[idx].cast<double>() - center).cast<float>());
    normals.push_back(mesh.normals[idx]);
  }
  if (metric == PairMetric::kEuclidean) return;
  const auto of_vertices = skin_errors(mesh);
  errors.reserve(of_vertices.size());
  for (const auto idx : tree.order) errors.push_back(of_vertices[idx]);
  largest_below_mm2 = largest_variances_below(tree, errors);
}

}  // namespace mor::internal
