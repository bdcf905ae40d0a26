// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/surface_finish.h"

#include <algorithm>
#include <cmath>

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

/// Brings a vertex back to within half a voxel of where it was, along each of the grid's axes.
void hold_near(TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& places, const Volume& grid) {
  const Eigen::Matrix3f ct_from_grid = grid.ct_from_grid.linear().cast<float>();
  const Eigen::Vector3f most_mm = 0.5F * grid.spacing_mm.cast<float>();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector3f moved = ct_from_grid.transpose() * (mesh.vertices[i] - places[i]);
    mesh.vertices[i] = places[i] + ct_from_grid * moved.cwiseMin(most_mm).cwiseMax(-most_mm);
  }
}

void smooth(TriangleMesh& mesh, const MeshLinks& links, const Volume& grid) {
  const auto places = mesh.vertices;
  for (int i = 0; i < kSmoothingRounds; ++i) {
    smooth_step(mesh, links, kShrink);
    smooth_step(mesh, links, kGrow);
  }
  hold_near(mesh, places, grid);
}

bool is_closed(const MeshLinks& links) {
  for (std::uint32_t i = 0; i < links.num_vertices(); ++i)
    if (links.edges_at(i).size() != links.triangles_at(i).size()) return false;
  return true;
}

struct Extent {
  double volume_mm3 = 0.0;
  double area_mm2 = 0.0;
};

Extent extent_of(const TriangleMesh& mesh) {
  Extent extent;
  const Eigen::Vector3f middle = mesh.vertices.front();
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d from = (mesh.vertices[a] - middle).cast<double>();
    const Eigen::Vector3d turn = (mesh.vertices[b] - mesh.vertices[a])
                                     .cast<double>()
                                     .cross((mesh.vertices[c] - mesh.vertices[a]).cast<double>());
    extent.volume_mm3 += from.dot(turn) / 6.0;
    extent.area_mm2 += 0.5 * turn.norm();
  }
  return extent;
}

/// Moves all vertices alike along their normals until the mesh encloses the volume.
void restore_volume(TriangleMesh& mesh, double volume_mm3, double most_mm) {
  constexpr int kRounds = 3;
  double left_mm = most_mm;
  for (int i = 0; i < kRounds; ++i) {
    const Extent extent = extent_of(mesh);
    if (!(extent.area_mm2 > 0.0)) return;
    const double step_mm =
        std::clamp((volume_mm3 - extent.volume_mm3) / extent.area_mm2, -left_mm, left_mm);
    left_mm -= std::abs(step_mm);
    const auto normals = vertex_normals(mesh);
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k)
      mesh.vertices[k] += static_cast<float>(step_mm) * normals[k];
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

void finish_surface(TriangleMesh& mesh, const Volume& grid, const SurfaceFinish& finish) {
  if (mesh.empty()) return;
  auto volume_mm3 = finish.volume_mm3;
  {
    const MeshLinks links(mesh);
    if (!volume_mm3 && is_closed(links)) volume_mm3 = extent_of(mesh).volume_mm3;
    smooth(mesh, links, grid);
  }
  if (finish.when_smooth) finish.when_smooth();
  mesh = simplified(mesh, finish.num_triangles);
  if (volume_mm3) restore_volume(mesh, *volume_mm3, 0.5 * grid.spacing_mm.minCoeff());
  mesh.normals = vertex_normals(mesh);
}

void finish_given_surface(TriangleMesh& mesh, int num_triangles) {
  if (mesh.empty()) return;
  mesh = simplified(mesh, num_triangles);
  mesh.normals = vertex_normals(mesh);
}

}  // namespace mor::internal
