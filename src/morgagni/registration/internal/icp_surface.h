// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/internal/balanced_kd_tree.h"
#include "morgagni/registration/internal/localization_error.h"

namespace mor::internal {

/// How ICP measures the distance of a pair.
enum class PairMetric : std::uint8_t {
  kEuclidean,
  kWeighted,  ///< By the pair's covariance (A-ICP).
};

/// The metric of an ICP method.
[[nodiscard]] PairMetric metric_of(RegistrationMethod method);

/// The fixed surface as the ICP family uses it, on any device: its points in the order of their
/// tree, about their centre, so that floats keep their digits. Never changes.
struct IcpSurface {
  IcpSurface(const TriangleMesh& mesh, PairMetric pair_metric);

  PairMetric metric;
  Eigen::Vector3d center;  ///< mm, frame fixed. All else is relative to it.
  BalancedKdTree tree;
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  /// Where the metric is weighted:
  std::vector<SkinError> errors;
  /// of each node, the largest variance along the node's axis of what lies below it, itself
  /// included.
  std::vector<float> largest_below_mm2;
};

}  // namespace mor::internal
