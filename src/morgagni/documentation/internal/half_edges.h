// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// How often each directed edge a->b stands in the triangles.
class HalfEdges {
 public:
  explicit HalfEdges(const std::vector<Triangle>& triangles);

  [[nodiscard]] int count(std::uint32_t a, std::uint32_t b) const {
    const auto found = counts_.find(key(a, b));
    return found == counts_.end() ? 0 : found->second;
  }
  [[nodiscard]] bool has_edge(std::uint32_t a, std::uint32_t b) const {
    return count(a, b) + count(b, a) > 0;
  }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return (static_cast<std::uint64_t>(a) << 32U) | b;
  }
  std::unordered_map<std::uint64_t, int> counts_;
};

/// Gives each fan of triangles around a vertex a vertex of its own, so that surfaces no longer
/// touch in a point. The triangles stay in their order. @return How many vertices were added.
std::size_t cut_pinched_vertices(TriangleMesh& mesh);

/// The rims of the holes: closed ways along edges with one triangle, in the direction of that
/// triangle. Each vertex has one fan (cut_pinched_vertices).
[[nodiscard]] std::vector<std::vector<std::uint32_t>> find_rims(const TriangleMesh& mesh);

/// Triangles that close a rim, by cutting ears (Meisters 1975) in the rim's mean plane; no new
/// vertices, no edge that the mesh has already where that can be avoided.
[[nodiscard]] std::vector<Triangle> lid_of(const TriangleMesh& mesh,
                                           const std::vector<std::uint32_t>& rim,
                                           const HalfEdges& edges);

}  // namespace mor::internal
