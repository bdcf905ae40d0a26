// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// Triangles that are laid flat together.
struct SkinChart {
  std::vector<std::uint32_t> triangles;  ///< In ascending order.
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
};

/// Of each triangle the neighbours over its three edges. An edge of more than two triangles
/// connects none of them.
using Neighbors = std::vector<std::array<std::uint32_t, 3>>;
inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();
[[nodiscard]] Neighbors triangle_neighbors(const TriangleMesh& mesh);

/// Unit normals from the corners' order; zero for a triangle without area.
[[nodiscard]] std::vector<Eigen::Vector3f> triangle_normals(const TriangleMesh& mesh);

/// Every triangle in one chart, within `max_tilt_rad` of its normal where it could be; charts of a
/// few triangles join a neighbour that they lean out of by no more than 70 degrees.
[[nodiscard]] std::vector<SkinChart> grow_charts(const TriangleMesh& mesh, double max_tilt_rad);

/// The triangles of a chart laid flat, corner by corner, in mm: seen along -normal, y down.
using FlatTriangle = std::array<Eigen::Vector2f, 3>;
[[nodiscard]] std::vector<FlatTriangle> laid_flat(const TriangleMesh& mesh, const SkinChart& chart);

/// Takes the triangles that overlap another one out of the chart, and returns them.
[[nodiscard]] std::vector<std::uint32_t> take_overlapping(const TriangleMesh& mesh,
                                                          SkinChart& chart);

/// Whether two flat triangles share more than an edge; touching is not overlapping.
[[nodiscard]] bool do_overlap(const FlatTriangle& a, const FlatTriangle& b);

}  // namespace mor::internal
