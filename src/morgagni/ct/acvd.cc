// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/acvd.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "morgagni/ct/internal/clustering.h"
#include "morgagni/ct/internal/dual_mesh.h"
#include "morgagni/ct/internal/mesh_links.h"
#include "morgagni/ct/internal/subdivision.h"

namespace mor {
namespace {

using internal::Clustering;
using internal::kNoCluster;
using internal::MeshLinks;

constexpr const char* kStage = "remesh";
constexpr int kMaxRepairs = 10;

/// A third of each triangle's area, times the density that the gradation asks for.
std::vector<float> weights_of(const TriangleMesh& mesh, const MeshLinks& links, double gradation) {
  std::vector<float> weights(mesh.vertices.size(), 0.0F);
  for (const auto& [a, b, c] : mesh.triangles) {
    const float area =
        0.5F *
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
    for (const auto corner : {a, b, c}) weights[corner] += area / 3.0F;
  }
  if (gradation > 0.0) {
    const auto density = internal::curvature_density(mesh, links, gradation);
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] *= density[i];
  }
  // A vertex of no weight could be in any cluster: it follows its neighbours with a little.
  constexpr float kLeast = 1e-6F;
  for (float& weight : weights) weight = std::max(weight, kLeast);
  return weights;
}

Result<void> check_input(const TriangleMesh& mesh, const AcvdOptions& options) {
  MOR_CHECK(options.check());
  if (mesh.vertices.size() < static_cast<std::size_t>(options.num_vertices)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the surface has " + std::to_string(mesh.vertices.size()) +
                          " vertices, fewer than the " + std::to_string(options.num_vertices) +
                          " asked for: ask for fewer");
  }
  return {};
}

/// Splits the clusters whose vertices are not the middle of one fan, until the dual is a manifold
/// or splitting helps no more.
std::vector<Triangle> manifold_dual(const TriangleMesh& mesh, Clustering& clustering) {
  auto triangles = internal::dual_triangles(mesh, clustering.cluster_of_vertex());
  for (int i = 0; i < kMaxRepairs; ++i) {
    const auto bad = internal::non_manifold_vertices(triangles, clustering.num_clusters());
    if (bad.empty()) break;
    for (const auto cluster : bad) clustering.split(cluster);
    clustering.settle();
    triangles = internal::dual_triangles(mesh, clustering.cluster_of_vertex());
  }
  return triangles;
}

/// Leaves out vertices that no triangle uses.
void drop_unused(TriangleMesh& mesh) {
  std::vector<std::uint32_t> names(mesh.vertices.size(), kNoCluster);
  std::vector<Eigen::Vector3f> used;
  for (auto& triangle : mesh.triangles) {
    for (auto& corner : triangle) {
      if (names[corner] == kNoCluster) {
        names[corner] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.vertices[corner]);
      }
      corner = names[corner];
    }
  }
  mesh.vertices = std::move(used);
}

}  // namespace

Result<void> AcvdOptions::check() const {
  if (num_vertices < 4) {
    return make_error(ErrorCode::kInvalidArgument,
                      "num_vertices must be at least 4, got " + std::to_string(num_vertices));
  }
  if (sub_sampling < 1 || sub_sampling > 1000) {
    return make_error(ErrorCode::kInvalidArgument,
                      "sub_sampling must be in [1, 1000], got " + std::to_string(sub_sampling));
  }
  if (!(gradation >= 0.0 && gradation <= 10.0)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "gradation must be in [0, 10], got " + std::to_string(gradation));
  }
  return {};
}

Result<TriangleMesh> remesh_acvd(const TriangleMesh& mesh,
                                 const AcvdOptions& options,
                                 const Progress& progress) {
  MOR_CHECK(check_input(mesh, options));
  const auto report = [&](double fraction) {
    if (progress) progress(kStage, fraction);
  };
  const auto num_clusters = static_cast<std::uint32_t>(options.num_vertices);
  const std::size_t wanted = static_cast<std::size_t>(options.sub_sampling) * num_clusters;

  // The clusters find their places on the mesh as it is; finer meshes only refine their borders.
  TriangleMesh fine = mesh;
  std::vector<std::uint32_t> clusters;
  std::vector<Triangle> dual;
  for (bool first = true;; first = false) {
    const MeshLinks links(fine);
    Clustering clustering(fine, links, weights_of(fine, links, options.gradation));
    if (first) {
      clustering.start(num_clusters);
    } else {
      clustering.start(std::move(clusters), num_clusters);
    }
    clustering.minimize([&](double fraction) { report(0.9 * fraction); });
    const bool fine_enough = fine.vertices.size() >= wanted;
    if (!fine_enough) {
      clusters = clustering.cluster_of_vertex();
      internal::subdivide(fine, links, clusters);
      continue;
    }
    dual = manifold_dual(fine, clustering);
    report(0.95);
    TriangleMesh result;
    result.vertices = internal::place_vertices(
        fine, clustering.cluster_of_vertex(), clustering.num_clusters(), dual);
    result.triangles = std::move(dual);
    internal::separate_fans(result);
    drop_unused(result);
    result.normals = vertex_normals(result);
    report(1.0);
    return result;
  }
}

}  // namespace mor
