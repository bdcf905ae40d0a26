// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/nearest_triangles.h"

#include <algorithm>
#include <cmath>

#include "morgagni/registration/internal/closest_point.h"

namespace mor::internal {
namespace {

/// How far around a triangle nodes are measured against it, in grid steps: every node beside the
/// surface is then exact, and each of them hands its triangle on.
constexpr float kSeedReachSteps = 1.5F;

}  // namespace

NearestTriangles::NearestTriangles(const TriangleMesh& mesh,
                                   const Eigen::Vector3f& origin_mm,
                                   const std::array<int, 3>& size,
                                   float spacing_mm,
                                   float band_mm)
    : mesh_(mesh),
      origin_mm_(origin_mm),
      size_(size),
      spacing_mm_(spacing_mm),
      band_mm_(band_mm),
      triangle_(node_index(0, 0, size[2]), kNone),
      distance_mm_(triangle_.size(), std::numeric_limits<float>::infinity()) {
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) seed(i);
  // One sweep an octant of directions carries every triangle straight to where it is nearest.
  for (int octant = 0; octant < 8; ++octant) {
    sweep({(octant & 1) != 0 ? -1 : 1, (octant & 2) != 0 ? -1 : 1, (octant & 4) != 0 ? -1 : 1});
  }
}

void NearestTriangles::try_triangle(std::size_t node,
                                    const Eigen::Vector3f& p,
                                    std::uint32_t triangle) {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const float distance =
      (closest_point_on_triangle(p, mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]).point -
       p)
          .norm();
  // The second condition makes ties independent of the order of sweeps.
  if (distance < distance_mm_[node] ||
      (distance == distance_mm_[node] && triangle < triangle_[node])) {
    distance_mm_[node] = distance;
    triangle_[node] = triangle;
  }
}

void NearestTriangles::seed(std::uint32_t triangle) {
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const Eigen::Vector3f low =
      mesh_.vertices[a].cwiseMin(mesh_.vertices[b]).cwiseMin(mesh_.vertices[c]);
  const Eigen::Vector3f high =
      mesh_.vertices[a].cwiseMax(mesh_.vertices[b]).cwiseMax(mesh_.vertices[c]);
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    first[k] = std::max(0,
                        static_cast<int>(std::ceil((low[axis] - origin_mm_[axis]) / spacing_mm_ -
                                                   kSeedReachSteps)));
    last[k] = std::min(size_[k] - 1,
                       static_cast<int>(std::floor((high[axis] - origin_mm_[axis]) / spacing_mm_ +
                                                   kSeedReachSteps)));
  }
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      for (int x = first[0]; x <= last[0]; ++x) {
        try_triangle(node_index(x, y, z), position_mm(x, y, z), triangle);
      }
    }
  }
}

void NearestTriangles::sweep(const std::array<int, 3>& direction) {
  const auto start = [&](int axis) {
    const auto k = static_cast<std::size_t>(axis);
    return direction[k] > 0 ? 0 : size_[k] - 1;
  };
  const std::array<std::ptrdiff_t, 3> back = {
      -direction[0],
      -direction[1] * static_cast<std::ptrdiff_t>(size_[0]),
      -direction[2] * static_cast<std::ptrdiff_t>(size_[0]) * size_[1]};
  for (int k = 0, z = start(2); k < size_[2]; ++k, z += direction[2]) {
    for (int j = 0, y = start(1); j < size_[1]; ++j, y += direction[1]) {
      for (int i = 0, x = start(0); i < size_[0]; ++i, x += direction[0]) {
        const std::size_t node = node_index(x, y, z);
        const std::array<bool, 3> inside = {i > 0, j > 0, k > 0};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (!inside[axis]) continue;
          const std::size_t neighbor =
              static_cast<std::size_t>(static_cast<std::ptrdiff_t>(node) + back[axis]);
          // A neighbour's triangle is nearer to this node by one step at most.
          const float best_possible = distance_mm_[neighbor] - spacing_mm_;
          if (best_possible > band_mm_ || best_possible >= distance_mm_[node]) continue;
          if (triangle_[neighbor] == triangle_[node]) continue;
          try_triangle(node, position_mm(x, y, z), triangle_[neighbor]);
        }
      }
    }
  }
}

}  // namespace mor::internal
