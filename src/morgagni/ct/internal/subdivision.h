// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "morgagni/ct/internal/mesh_links.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// Parts every triangle into four at the middles of its edges. A new vertex gets the cluster of its
/// edge's first vertex.
void subdivide(TriangleMesh& mesh, const MeshLinks& links, std::vector<std::uint32_t>& clusters);

/// How densely each vertex wants its surroundings sampled: its bending in 1/mm to the power of
/// `gradation`, evened out over its neighbours, between limits that keep clusters from vanishing.
[[nodiscard]] std::vector<float> curvature_density(const TriangleMesh& mesh,
                                                   const MeshLinks& links,
                                                   double gradation);

}  // namespace mor::internal
