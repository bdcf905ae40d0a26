// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/surface_finish.h"

#include <algorithm>

#include <meshoptimizer.h>

#include "morgagni/ct/internal/mesh_links.h"

namespace mor::internal {
namespace {

/// Taubin, "A signal processing approach to fair surface design", 1995: a step inwards, a larger
/// one outwards, so that stairs vanish and the volume stays.
constexpr int kSmoothingRounds = 5;
constexpr float kShrink = 0.5F;
constexpr float kGrow = -0.53F;

/// Moves every vertex by `factor` of the way to the middle of its neighbours; open borders stay.
void smooth_step(TriangleMesh& mesh, const MeshLinks& links, float factor) {
  std::vector<Eigen::Vector3f> sums(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b] : links.edges()) {
    sums[a] += mesh.vertices[b];
    sums[b] += mesh.vertices[a];
  }
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    const std::size_t num_edges = links.edges_at(i).size();
    if (num_edges == 0 || num_edges != links.triangles_at(i).size()) continue;
    const Eigen::Vector3f middle = sums[i] / static_cast<float>(num_edges);
    mesh.vertices[i] += factor * (middle - mesh.vertices[i]);
  }
}

void smooth(TriangleMesh& mesh) {
  const MeshLinks links(mesh);
  for (int i = 0; i < kSmoothingRounds; ++i) {
    smooth_step(mesh, links, kShrink);
    smooth_step(mesh, links, kGrow);
  }
}

/// Fewer triangles, in the order in which a graphics card draws them best.
TriangleMesh simplified(const TriangleMesh& mesh, int num_triangles) {
  constexpr float kMaxError = 0.05F;  // Of the mesh's extent: the number of triangles decides.
  const auto* indices = mesh.triangles.front().data();
  const std::size_t num_indices = 3 * mesh.triangles.size();
  std::vector<unsigned> kept(num_indices);
  kept.resize(meshopt_simplify(kept.data(),
                               indices,
                               num_indices,
                               mesh.vertices.front().data(),
                               mesh.vertices.size(),
                               sizeof(Eigen::Vector3f),
                               std::min(3 * static_cast<std::size_t>(num_triangles), num_indices),
                               kMaxError,
                               0,
                               nullptr));
  meshopt_optimizeVertexCache(kept.data(), kept.data(), kept.size(), mesh.vertices.size());
  TriangleMesh result;
  result.vertices.resize(mesh.vertices.size());
  result.vertices.resize(meshopt_optimizeVertexFetch(result.vertices.data(),
                                                     kept.data(),
                                                     kept.size(),
                                                     mesh.vertices.data(),
                                                     mesh.vertices.size(),
                                                     sizeof(Eigen::Vector3f)));
  for (std::size_t i = 0; i < kept.size(); i += 3)
    result.triangles.push_back({kept[i], kept[i + 1], kept[i + 2]});
  return result;
}

}  // namespace

void finish_surface(TriangleMesh& mesh,
                    int num_triangles,
                    const std::function<void()>& when_smooth) {
  if (mesh.empty()) return;
  smooth(mesh);
  if (when_smooth) when_smooth();
  finish_given_surface(mesh, num_triangles);
}

void finish_given_surface(TriangleMesh& mesh, int num_triangles) {
  if (mesh.empty()) return;
  mesh = simplified(mesh, num_triangles);
  mesh.normals = vertex_normals(mesh);
}

}  // namespace mor::internal
