// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Eigenvalues>

#include "morgagni/ct/internal/clustering.h"
#include "morgagni/ct/internal/dual_mesh.h"

namespace mor::internal {
namespace {

/// Directions whose singular value is below this share of the largest are flat: the planes do not
/// say where along them the vertex lies.
constexpr double kFlatShare = 0.01;
constexpr int kMaxFlipRounds = 20;

/// What a cluster's triangles say, about its own middle.
struct ClusterShape {
  double area = 0.0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d quadric = Eigen::Matrix3d::Zero();  ///< Sum of area n n^T.
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();     ///< Sum of area n (n . (p - middle)).
  double reach_sq = 0.0;  ///< Squared distance of the farthest corner of its triangles.
};

/// Calls visit(cluster, triangle) for each corner of each triangle.
template <class Visit>
void for_corners(const TriangleMesh& mesh,
                 const std::vector<std::uint32_t>& cluster_of_vertex,
                 const Visit& visit) {
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t cluster = cluster_of_vertex[triangle[i]];
      if (cluster != kNoCluster) visit(cluster, triangle, i);
    }
  }
}

std::vector<ClusterShape> shapes_of(const TriangleMesh& mesh,
                                    const std::vector<std::uint32_t>& cluster_of_vertex,
                                    std::uint32_t num_clusters) {
  std::vector<ClusterShape> shapes(num_clusters);
  const auto corner = [&](const Triangle& triangle, std::size_t i) -> Eigen::Vector3d {
    return mesh.vertices[triangle[i % 3]].cast<double>();
  };
  for_corners(mesh, cluster_of_vertex, [&](auto cluster, const Triangle& triangle, std::size_t i) {
    const Eigen::Vector3d here = corner(triangle, i);
    const Eigen::Vector3d cross =
        (corner(triangle, i + 1) - here).cross(corner(triangle, i + 2) - here);
    ClusterShape& shape = shapes[cluster];
    const double area = cross.norm() / 6.0;
    shape.area += area;
    shape.middle += area * here;
    shape.normal += cross / 6.0;
  });
  for (auto& shape : shapes)
    if (shape.area > 0.0) shape.middle /= shape.area;
  for_corners(mesh, cluster_of_vertex, [&](auto cluster, const Triangle& triangle, std::size_t i) {
    const Eigen::Vector3d here = corner(triangle, i);
    const Eigen::Vector3d cross =
        (corner(triangle, i + 1) - here).cross(corner(triangle, i + 2) - here);
    ClusterShape& shape = shapes[cluster];
    shape.reach_sq = std::max(shape.reach_sq, (here - shape.middle).squaredNorm());
    const double length = cross.norm();
    if (length <= 0.0) return;
    const Eigen::Vector3d normal = cross / length;
    shape.quadric += length / 6.0 * normal * normal.transpose();
    shape.pull += length / 6.0 * normal * normal.dot(here - shape.middle);
  });
  return shapes;
}

/// Walls along the open borders: planes through a border edge, upright on its triangle, that keep
/// the border's clusters on it.
void add_border_walls(const TriangleMesh& mesh,
                      const std::vector<std::uint32_t>& cluster_of_vertex,
                      std::vector<ClusterShape>& shapes) {
  std::vector<std::array<std::uint32_t, 3>> edges;  // Lower, upper vertex, triangle.
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      edges.push_back({low, high, t});
    }
  }
  std::sort(edges.begin(), edges.end());
  const auto same_edge = [](const auto& a, const auto& b) { return a[0] == b[0] && a[1] == b[1]; };
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool alone = (i == 0 || !same_edge(edges[i], edges[i - 1])) &&
                       (i + 1 == edges.size() || !same_edge(edges[i], edges[i + 1]));
    if (!alone) continue;
    const auto& [a, b, c] = mesh.triangles[edges[i][2]];
    const Eigen::Vector3d start = mesh.vertices[edges[i][0]].cast<double>();
    const Eigen::Vector3d along = mesh.vertices[edges[i][1]].cast<double>() - start;
    const Eigen::Vector3d normal = (mesh.vertices[b] - mesh.vertices[a])
                                       .cross(mesh.vertices[c] - mesh.vertices[a])
                                       .cast<double>();
    const Eigen::Vector3d wall = along.cross(normal).normalized();
    for (const std::uint32_t vertex : {edges[i][0], edges[i][1]}) {
      if (cluster_of_vertex[vertex] == kNoCluster) continue;
      ClusterShape& shape = shapes[cluster_of_vertex[vertex]];
      const double weight = 0.5 * along.norm() * std::sqrt(shape.area);
      shape.quadric += weight * wall * wall.transpose();
      shape.pull += weight * wall * wall.dot(start - shape.middle);
    }
  }
}

Eigen::Vector3d best_place(const ClusterShape& shape) {
  if (shape.area <= 0.0) return shape.middle;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(shape.quadric);
  const double largest = solver.eigenvalues()[2];
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double value = solver.eigenvalues()[i];
    if (value <= kFlatShare * largest) continue;
    const Eigen::Vector3d direction = solver.eigenvectors().col(i);
    step += direction * (direction.dot(shape.pull) / value);
  }
  const double reach = std::sqrt(shape.reach_sq);
  return shape.middle + step * std::min(1.0, reach / std::max(step.norm(), 1e-12));
}

/// Whether a triangle looks the other way than the surface it stands for.
bool is_turned(const Triangle& triangle,
               const std::vector<Eigen::Vector3d>& places,
               const std::vector<ClusterShape>& shapes) {
  const auto& [a, b, c] = triangle;
  const Eigen::Vector3d normal = (places[b] - places[a]).cross(places[c] - places[a]);
  const Eigen::Vector3d wanted = shapes[a].normal + shapes[b].normal + shapes[c].normal;
  return normal.dot(wanted) <= 0.1 * normal.norm() * wanted.norm();
}

/// The corners of pairs of neighbouring triangles that look away from each other: a fold, as thin
/// parts (an ear) leave where a cluster reaches around their edge.
std::vector<std::uint32_t> folded_corners(const std::vector<Triangle>& triangles,
                                          const std::vector<Eigen::Vector3d>& places) {
  constexpr double kCosOfFold = -0.8;  // 143 degrees.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> triangle_at;
  const auto normal_of = [&](const Triangle& t) -> Eigen::Vector3d {
    return (places[t[1]] - places[t[0]]).cross(places[t[2]] - places[t[0]]).normalized();
  };
  std::vector<std::uint32_t> corners;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangles[t][i];
      const std::uint32_t to = triangles[t][(i + 1) % 3];
      triangle_at[{from, to}] = t;
      const auto other = triangle_at.find({to, from});
      if (other == triangle_at.end()) continue;
      const auto& neighbor = triangles[other->second];
      if (normal_of(triangles[t]).dot(normal_of(neighbor)) > kCosOfFold) continue;
      corners.insert(corners.end(), triangles[t].begin(), triangles[t].end());
      corners.insert(corners.end(), neighbor.begin(), neighbor.end());
    }
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

/// Half way to the middle of their neighbours, all at once, until no fold is left.
void unfold(const std::vector<Triangle>& triangles, std::vector<Eigen::Vector3d>& places) {
  for (int round = 0; round < kMaxFlipRounds; ++round) {
    const auto corners = folded_corners(triangles, places);
    if (corners.empty()) return;
    std::map<std::uint32_t, std::pair<Eigen::Vector3d, int>> around;
    for (const std::uint32_t corner : corners) around[corner] = {Eigen::Vector3d::Zero(), 0};
    for (const auto& triangle : triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const auto found = around.find(triangle[i]);
        if (found == around.end()) continue;
        found->second.first += places[triangle[(i + 1) % 3]] + places[triangle[(i + 2) % 3]];
        found->second.second += 2;
      }
    }
    for (const auto& [corner, sum] : around)
      places[corner] = 0.5 * (places[corner] + sum.first / sum.second);
  }
}

}  // namespace

std::vector<Eigen::Vector3f> place_vertices(const TriangleMesh& mesh,
                                            const std::vector<std::uint32_t>& cluster_of_vertex,
                                            std::uint32_t num_clusters,
                                            const std::vector<Triangle>& triangles) {
  auto shapes = shapes_of(mesh, cluster_of_vertex, num_clusters);
  add_border_walls(mesh, cluster_of_vertex, shapes);
  std::vector<Eigen::Vector3d> places;
  for (const auto& shape : shapes) places.push_back(best_place(shape));
  for (int i = 0; i < kMaxFlipRounds; ++i) {
    std::vector<std::uint32_t> turned;
    for (const auto& triangle : triangles)
      if (is_turned(triangle, places, shapes))
        turned.insert(turned.end(), triangle.begin(), triangle.end());
    if (turned.empty()) break;
    for (const auto cluster : turned)
      places[cluster] = 0.5 * (places[cluster] + shapes[cluster].middle);
  }
  unfold(triangles, places);
  std::vector<Eigen::Vector3f> result;
  for (const auto& place : places) result.push_back(place.cast<float>());
  return result;
}

}  // namespace mor::internal
