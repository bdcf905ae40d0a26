// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/mesh_links.h"

#include <algorithm>

namespace mor::internal {
namespace {

/// Turns counts per vertex, stored one place up, into where each vertex's list starts.
void accumulate(std::vector<std::uint32_t>& starts) {
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
}

}  // namespace

MeshLinks::MeshLinks(const TriangleMesh& mesh) {
  link_triangles(mesh);
  find_edges(mesh);
  link_edges();
}

void MeshLinks::link_triangles(const TriangleMesh& mesh) {
  triangle_starts_.assign(mesh.vertices.size() + 1, 0);
  for (const auto& triangle : mesh.triangles)
    for (const auto vertex : triangle) ++triangle_starts_[vertex + 1];
  accumulate(triangle_starts_);
  triangles_.resize(3 * mesh.triangles.size());
  auto next = triangle_starts_;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    for (const auto vertex : mesh.triangles[i]) triangles_[next[vertex]++] = i;
}

void MeshLinks::find_edges(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> upper;
  for (std::uint32_t vertex = 0; vertex < num_vertices(); ++vertex) {
    upper.clear();
    for (const auto triangle : triangles_at(vertex))
      for (const auto other : mesh.triangles[triangle])
        if (other > vertex) upper.push_back(other);
    std::sort(upper.begin(), upper.end());
    upper.erase(std::unique(upper.begin(), upper.end()), upper.end());
    for (const auto other : upper) edges_.push_back({vertex, other});
  }
}

void MeshLinks::link_edges() {
  edge_starts_.assign(num_vertices() + 1, 0);
  for (const auto& edge : edges_)
    for (const auto vertex : edge) ++edge_starts_[vertex + 1];
  accumulate(edge_starts_);
  edges_at_.resize(2 * edges_.size());
  auto next = edge_starts_;
  for (std::uint32_t i = 0; i < edges_.size(); ++i)
    for (const auto vertex : edges_[i]) edges_at_[next[vertex]++] = i;
}

}  // namespace mor::internal
