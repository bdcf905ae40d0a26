// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/subdivision.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mor::internal {
namespace {

constexpr int kSmoothingRounds = 5;
/// Bending is kept within this factor of its mean.
constexpr float kMaxBendingRatio = 20.0F;

/// Largest angle between the normals at the two ends of an edge, by its length, in 1/mm.
std::vector<float> bending_of(const TriangleMesh& mesh, const MeshLinks& links) {
  const auto normals = vertex_normals(mesh);
  std::vector<float> bending(mesh.vertices.size(), 0.0F);
  for (const auto& [a, b] : links.edges()) {
    const float length = (mesh.vertices[a] - mesh.vertices[b]).norm();
    if (length <= 0.0F) continue;
    const float bend = (normals[a] - normals[b]).norm() / length;
    bending[a] = std::max(bending[a], bend);
    bending[b] = std::max(bending[b], bend);
  }
  return bending;
}

void smooth(std::vector<float>& values, const MeshLinks& links) {
  std::vector<float> sums = values;
  for (const auto& [a, b] : links.edges()) {
    sums[a] += values[b];
    sums[b] += values[a];
  }
  for (std::uint32_t i = 0; i < values.size(); ++i)
    values[i] = sums[i] / static_cast<float>(links.edges_at(i).size() + 1);
}

}  // namespace

void subdivide(TriangleMesh& mesh, const MeshLinks& links, std::vector<std::uint32_t>& clusters) {
  const auto num_old = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.reserve(num_old + links.edges().size());
  clusters.reserve(num_old + links.edges().size());
  for (const auto& [a, b] : links.edges()) {
    mesh.vertices.push_back(0.5F * (mesh.vertices[a] + mesh.vertices[b]));
    clusters.push_back(clusters[a]);
  }
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    for (const auto edge : links.edges_at(a)) {
      const auto& ends = links.edges()[edge];
      if (ends[0] == b || ends[1] == b) return num_old + edge;
    }
    return a;
  };
  std::vector<Triangle> triangles;
  triangles.reserve(4 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t ab = middle(a, b);
    const std::uint32_t bc = middle(b, c);
    const std::uint32_t ca = middle(c, a);
    triangles.insert(triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(triangles);
  mesh.normals.clear();
}

std::vector<float> curvature_density(const TriangleMesh& mesh,
                                     const MeshLinks& links,
                                     double gradation) {
  auto bending = bending_of(mesh, links);
  for (int i = 0; i < kSmoothingRounds; ++i) smooth(bending, links);
  double sum = 0.0;
  for (const float bend : bending) sum += bend;
  const auto mean = static_cast<float>(sum / static_cast<double>(bending.size()));
  if (mean <= 0.0F) return std::vector<float>(bending.size(), 1.0F);
  for (float& bend : bending) {
    const float ratio = std::clamp(bend / mean, 1.0F / kMaxBendingRatio, kMaxBendingRatio);
    bend = std::pow(ratio, static_cast<float>(gradation));
  }
  return bending;
}

}  // namespace mor::internal
