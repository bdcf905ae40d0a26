// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// Which triangles meet at each vertex, and which edges there are.
class MeshLinks {
 public:
  using Edge = std::array<std::uint32_t, 2>;  ///< Lower vertex first.

  explicit MeshLinks(const TriangleMesh& mesh);

  [[nodiscard]] std::size_t num_vertices() const { return triangle_starts_.size() - 1; }
  [[nodiscard]] std::span<const std::uint32_t> triangles_at(std::uint32_t vertex) const {
    return {triangles_.data() + triangle_starts_[vertex],
            triangle_starts_[vertex + 1] - triangle_starts_[vertex]};
  }
  /// Indices into edges().
  [[nodiscard]] std::span<const std::uint32_t> edges_at(std::uint32_t vertex) const {
    return {edges_at_.data() + edge_starts_[vertex],
            edge_starts_[vertex + 1] - edge_starts_[vertex]};
  }
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }

 private:
  void link_triangles(const TriangleMesh& mesh);
  void find_edges(const TriangleMesh& mesh);
  void link_edges();

  std::vector<std::uint32_t> triangle_starts_, triangles_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> edge_starts_, edges_at_;
};

}  // namespace mor::internal
