// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/dual_mesh.h"

#include <algorithm>
#include <unordered_map>

#include "morgagni/ct/internal/clustering.h"

namespace mor::internal {
namespace {

/// Half-edges by (from, to): how many triangles run along them.
using HalfEdges = std::unordered_map<std::uint64_t, std::uint32_t>;

std::uint64_t half_edge(std::uint32_t from, std::uint32_t to) {
  return std::uint64_t{from} << 32 | to;
}

HalfEdges count_half_edges(const std::vector<Triangle>& triangles) {
  HalfEdges counts;
  counts.reserve(3 * triangles.size());
  for (const auto& triangle : triangles)
    for (std::size_t i = 0; i < 3; ++i) ++counts[half_edge(triangle[i], triangle[(i + 1) % 3])];
  return counts;
}

std::vector<std::vector<std::uint32_t>> triangles_at(const std::vector<Triangle>& triangles,
                                                     std::size_t num_vertices) {
  std::vector<std::vector<std::uint32_t>> at(num_vertices);
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (const auto vertex : triangles[i]) at[vertex].push_back(i);
  return at;
}

/// Parts the triangles at `vertex` into fans: neighbours over an edge that only they share.
/// @return For each triangle the number of its fan, from 0.
std::vector<std::uint32_t> fans_of(std::uint32_t vertex,
                                   const std::vector<std::uint32_t>& around,
                                   const std::vector<Triangle>& triangles,
                                   const HalfEdges& counts) {
  const auto count = [&](std::uint32_t from, std::uint32_t to) {
    const auto found = counts.find(half_edge(from, to));
    return found == counts.end() ? 0U : found->second;
  };
  std::unordered_map<std::uint32_t, std::uint32_t> enters;  // By the corner after `vertex`.
  std::vector<std::uint32_t> next(around.size());
  std::vector<std::uint32_t> fan(around.size(), kNoCluster);
  const auto corner = [&](std::uint32_t i, std::size_t step) {
    const auto& triangle = triangles[around[i]];
    const auto at = static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), vertex) -
                                             triangle.begin());
    return triangle[(at + step) % 3];
  };
  for (std::uint32_t i = 0; i < around.size(); ++i) enters[corner(i, 1)] = i;
  std::vector<std::uint32_t> parent(around.size());
  for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  for (std::uint32_t i = 0; i < around.size(); ++i) {
    const std::uint32_t shared = corner(i, 2);
    const auto neighbor = enters.find(shared);
    if (neighbor == enters.end()) continue;
    if (count(vertex, shared) != 1 || count(shared, vertex) != 1) continue;
    const auto a = root(i);
    const auto b = root(neighbor->second);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::uint32_t num_fans = 0;
  for (std::uint32_t i = 0; i < around.size(); ++i) {
    const auto first = root(i);
    fan[i] = first == i ? num_fans++ : fan[first];
  }
  return fan;
}

}  // namespace

std::vector<Triangle> dual_triangles(const TriangleMesh& mesh,
                                     const std::vector<std::uint32_t>& cluster_of_vertex) {
  struct Sided {
    Triangle sorted;
    int sense;
  };
  std::vector<Sided> found;
  for (const auto& triangle : mesh.triangles) {
    Triangle clusters;
    for (std::size_t i = 0; i < 3; ++i) clusters[i] = cluster_of_vertex[triangle[i]];
    const auto [k, l, m] = clusters;
    if (k == l || l == m || m == k) continue;
    if (k == kNoCluster || l == kNoCluster || m == kNoCluster) continue;
    std::sort(clusters.begin(), clusters.end());
    const bool turned = clusters[0] == k ? l > m : clusters[0] == l ? m > k : k > l;
    found.push_back({clusters, turned ? -1 : 1});
  }
  std::sort(found.begin(), found.end(), [](const Sided& a, const Sided& b) {
    return a.sorted < b.sorted;
  });
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < found.size();) {
    int sense = 0;
    const Triangle sorted = found[i].sorted;
    for (; i < found.size() && found[i].sorted == sorted; ++i) sense += found[i].sense;
    if (sense > 0) triangles.push_back(sorted);
    if (sense < 0) triangles.push_back({sorted[0], sorted[2], sorted[1]});
  }
  return triangles;
}

std::vector<std::uint32_t> non_manifold_vertices(const std::vector<Triangle>& triangles,
                                                 std::size_t num_vertices) {
  const HalfEdges counts = count_half_edges(triangles);
  const auto at = triangles_at(triangles, num_vertices);
  std::vector<std::uint32_t> bad;
  for (std::uint32_t vertex = 0; vertex < num_vertices; ++vertex) {
    const auto fans = fans_of(vertex, at[vertex], triangles, counts);
    if (std::any_of(fans.begin(), fans.end(), [](std::uint32_t fan) { return fan > 0; }))
      bad.push_back(vertex);
  }
  return bad;
}

void separate_fans(TriangleMesh& mesh) {
  const HalfEdges counts = count_half_edges(mesh.triangles);
  const auto triangles = mesh.triangles;
  const auto num_vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto at = triangles_at(triangles, num_vertices);
  for (std::uint32_t vertex = 0; vertex < num_vertices; ++vertex) {
    const auto fans = fans_of(vertex, at[vertex], triangles, counts);
    std::vector<std::uint32_t> names = {vertex};
    for (std::size_t i = 0; i < fans.size(); ++i) {
      if (fans[i] == names.size()) {
        names.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
        mesh.vertices.push_back(Eigen::Vector3f(mesh.vertices[vertex]));
      }
      for (auto& corner : mesh.triangles[at[vertex][i]])
        if (corner == vertex) corner = names[fans[i]];
    }
  }
}

}  // namespace mor::internal
