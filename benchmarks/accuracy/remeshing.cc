// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Prints, as a Markdown table, how well ACVD and meshoptimizer's edge collapse keep the skin of a
// CT at the same number of vertices: remeshing CT [VERTICES].
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include <meshoptimizer.h>

#include "morgagni/ct/acvd.h"
#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/volume_import.h"

namespace {

using namespace mor;
using Clock = std::chrono::steady_clock;

TriangleMesh collapsed(const TriangleMesh& mesh, std::size_t num_triangles) {
  std::vector<unsigned> kept(3 * mesh.triangles.size());
  kept.resize(meshopt_simplify(kept.data(),
                               mesh.triangles.front().data(),
                               kept.size(),
                               mesh.vertices.front().data(),
                               mesh.vertices.size(),
                               sizeof(Eigen::Vector3f),
                               3 * num_triangles,
                               1.0F,
                               0,
                               nullptr));
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

void print_row(const char* name,
               const TriangleMesh& mesh,
               const TriangleMesh& full,
               double seconds) {
  constexpr int kNumPoints = 200000;
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const auto there = surface_distance(mesh, full, kNumPoints);
  const auto back = surface_distance(full, mesh, kNumPoints);
  const auto topology = mesh_topology(mesh);
  std::printf("| %s | %zu | %.3f / %.2f | %.3f / %.2f | %.1f | %.1f | %d | %d | %.1f |\n",
              name,
              mesh.vertices.size(),
              there.mean_mm,
              there.p99_mm,
              back.mean_mm,
              back.p99_mm,
              100.0 * topology.valence_5_to_7,
              topology.mean_min_angle_rad * kDegrees,
              topology.num_non_manifold_edges,
              topology.num_folded_edges,
              seconds);
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: remeshing CT [VERTICES]\n", stderr);
    return 2;
  }
  const int num_vertices = argc > 2 ? std::atoi(argv[2]) : 20000;
  const auto volume = import_volume(argv[1], {}, {});
  const auto skin = volume ? extract_skin(*volume, {.num_vertices = 100, .sub_sampling = 1}, {})
                           : Result<SkinSurfaces>(tl::unexpected(volume.error()));
  if (!skin) {
    std::fprintf(stderr, "%s\n", skin.error().message.c_str());
    return 1;
  }
  const TriangleMesh& full = skin->full;
  std::printf(
      "| method | vertices | to full, mean / p99 mm | from full, mean / p99 mm | valence 5-7 %% | "
      "mean smallest angle deg | non-manifold edges | folded edges | s |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  std::size_t num_triangles = 2 * static_cast<std::size_t>(num_vertices);
  for (const int sub_sampling : {1, 20, 100}) {
    const auto start = Clock::now();
    const auto mesh =
        remesh_acvd(full, {.num_vertices = num_vertices, .sub_sampling = sub_sampling}, {});
    if (!mesh) {
      std::fprintf(stderr, "%s\n", mesh.error().message.c_str());
      return 1;
    }
    num_triangles = mesh->triangles.size();
    const std::string name = "ACVD, sub-sampling " + std::to_string(sub_sampling);
    print_row(name.c_str(), *mesh, full, seconds_since(start));
  }
  const auto start = Clock::now();
  const auto mesh = collapsed(full, num_triangles);
  print_row("meshoptimizer simplify", mesh, full, seconds_since(start));
  return 0;
}
