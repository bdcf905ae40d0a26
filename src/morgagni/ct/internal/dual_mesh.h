// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The triangles between clusters: one for every triangle of the mesh whose corners lie in three
/// clusters, each only once, named by cluster. Two of opposite sense cancel out.
[[nodiscard]] std::vector<Triangle> dual_triangles(
    const TriangleMesh& mesh, const std::vector<std::uint32_t>& cluster_of_vertex);

/// The vertices at which triangles do not form one fan or one closed ring, ascending: on an edge of
/// more than two triangles, or where two fans touch in a point.
[[nodiscard]] std::vector<std::uint32_t> non_manifold_vertices(
    const std::vector<Triangle>& triangles, std::size_t num_vertices);

/// Gives every fan at a vertex a vertex of its own, at the same place, so that the mesh is a
/// manifold. Triangles at edges of more than two triangles come apart there.
void separate_fans(TriangleMesh& mesh);

/// Places each cluster's vertex where the planes of its triangles meet, as far as they say so
/// (quadric, by singular values), else at its middle; clusters at an open border stay on the
/// border. A vertex that would turn a triangle over goes to its cluster's middle.
/// @param triangles  The dual's; @return one place per cluster.
[[nodiscard]] std::vector<Eigen::Vector3f> place_vertices(
    const TriangleMesh& mesh,
    const std::vector<std::uint32_t>& cluster_of_vertex,
    std::uint32_t num_clusters,
    const std::vector<Triangle>& triangles);

}  // namespace mor::internal
