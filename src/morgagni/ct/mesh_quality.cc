// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/mesh_quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/triangle_grid.h"

namespace mor {
namespace {

constexpr unsigned kSeed = 1;

std::vector<Eigen::Vector3f> points_on(const TriangleMesh& mesh, int num_points) {
  std::vector<double> areas;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f ab = mesh.vertices[b] - mesh.vertices[a];
    areas.push_back(ab.cross(mesh.vertices[c] - mesh.vertices[a]).norm());
  }
  std::mt19937 random(kSeed);
  std::discrete_distribution<std::size_t> any(areas.begin(), areas.end());
  std::uniform_real_distribution<float> share(0.0F, 1.0F);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < num_points; ++i) {
    const auto& [a, b, c] = mesh.triangles[any(random)];
    float u = share(random);
    float v = share(random);
    if (u + v > 1.0F) {
      u = 1.0F - u;
      v = 1.0F - v;
    }
    points.push_back(mesh.vertices[a] + u * (mesh.vertices[b] - mesh.vertices[a]) +
                     v * (mesh.vertices[c] - mesh.vertices[a]));
  }
  return points;
}

Eigen::Vector3d cross_of(const TriangleMesh& mesh, const Triangle& triangle) {
  const auto corner = [&](int i) -> Eigen::Vector3d {
    return mesh.vertices[triangle[static_cast<std::size_t>(i)]].cast<double>();
  };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0));
}

double smallest_angle_rad(const TriangleMesh& mesh, const Triangle& triangle) {
  double smallest = std::numbers::pi;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d here = mesh.vertices[triangle[i]].cast<double>();
    const Eigen::Vector3d next = mesh.vertices[triangle[(i + 1) % 3]].cast<double>() - here;
    const Eigen::Vector3d last = mesh.vertices[triangle[(i + 2) % 3]].cast<double>() - here;
    smallest = std::min(smallest, std::atan2(next.cross(last).norm(), next.dot(last)));
  }
  return smallest;
}

struct EdgeUse {
  std::uint32_t low = 0, high = 0, triangle = 0;
  bool upwards = false;
};

std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh) {
  std::vector<EdgeUse> uses;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = mesh.triangles[t][i];
      const std::uint32_t to = mesh.triangles[t][(i + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::pair(a.low, a.high) < std::pair(b.low, b.high);
  });
  return uses;
}

/// Counts over the edges; marks the vertices on open borders and counts each vertex's edges.
void judge_edges(const TriangleMesh& mesh, MeshTopology& topology) {
  const double folded = std::cos(150.0 / 180.0 * std::numbers::pi);
  std::vector<int> valence(mesh.vertices.size());
  std::vector<char> at_border(mesh.vertices.size());
  const auto uses = edge_uses(mesh);
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i + 1;
    while (end < uses.size() && uses[end].low == uses[i].low && uses[end].high == uses[i].high)
      ++end;
    const std::size_t count = end - i;
    ++valence[uses[i].low];
    ++valence[uses[i].high];
    if (count == 1) {
      ++topology.num_open_edges;
      at_border[uses[i].low] = at_border[uses[i].high] = 1;
    } else if (count > 2 || uses[i].upwards == uses[i + 1].upwards) {
      ++topology.num_non_manifold_edges;
    } else {
      const Eigen::Vector3d one = cross_of(mesh, mesh.triangles[uses[i].triangle]);
      const Eigen::Vector3d two = cross_of(mesh, mesh.triangles[uses[i + 1].triangle]);
      if (one.dot(two) < folded * one.norm() * two.norm()) ++topology.num_folded_edges;
    }
    i = end;
  }
  int num_inner = 0;
  int num_good = 0;
  for (std::size_t i = 0; i < valence.size(); ++i) {
    if (valence[i] == 0) ++topology.num_unused_vertices;
    if (valence[i] == 0 || at_border[i] != 0) continue;
    ++num_inner;
    if (valence[i] >= 5 && valence[i] <= 7) ++num_good;
  }
  topology.valence_5_to_7 = num_inner > 0 ? static_cast<double>(num_good) / num_inner : 0.0;
}

int count_components(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<char> used(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    used[a] = used[b] = used[c] = 1;
    parent[root(b)] = root(a);
    parent[root(c)] = root(a);
  }
  int count = 0;
  for (std::uint32_t i = 0; i < parent.size(); ++i)
    if (used[i] != 0 && root(i) == i) ++count;
  return count;
}

}  // namespace

SurfaceDistance surface_distance(const TriangleMesh& from, const TriangleMesh& to, int num_points) {
  const auto points = points_on(from, num_points);
  const internal::TriangleGrid grid(to);
  std::vector<double> distances(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    distances[i] = grid.distance_mm(points[i]);
  });
  std::sort(distances.begin(), distances.end());
  SurfaceDistance result;
  result.mean_mm = std::accumulate(distances.begin(), distances.end(), 0.0) /
                   static_cast<double>(distances.size());
  result.p99_mm = distances[distances.size() * 99 / 100];
  result.max_mm = distances.back();
  return result;
}

MeshTopology mesh_topology(const TriangleMesh& mesh) {
  MeshTopology topology;
  topology.min_angle_rad = std::numbers::pi;
  double sum = 0.0;
  for (const auto& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle;
    constexpr double kNoArea = 1e-9;
    if (a == b || b == c || c == a || cross_of(mesh, triangle).norm() < kNoArea)
      ++topology.num_degenerate;
    const double angle = smallest_angle_rad(mesh, triangle);
    topology.min_angle_rad = std::min(topology.min_angle_rad, angle);
    sum += angle;
  }
  topology.mean_min_angle_rad = sum / static_cast<double>(mesh.triangles.size());
  judge_edges(mesh, topology);
  topology.num_components = count_components(mesh);
  return topology;
}

}  // namespace mor
