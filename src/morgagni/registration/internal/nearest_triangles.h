// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// For each node of a grid, the triangle of a mesh that is nearest, up to a distance.
///
/// Nodes beside a triangle are measured against it; then each node tries the triangles of its
/// neighbours, in eight sweeps over the grid, as a vector distance transform does (Danielsson
/// 1980). Exact beside the surface, and to a small share of the spacing away from it.
class NearestTriangles {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// @param size  Nodes along x, y, z; node (0, 0, 0) is at `origin_mm`.
  NearestTriangles(const TriangleMesh& mesh,
                   const Eigen::Vector3f& origin_mm,
                   const std::array<int, 3>& size,
                   float spacing_mm,
                   float band_mm);

  [[nodiscard]] std::uint32_t triangle(int x, int y, int z) const {
    return triangle_[node_index(x, y, z)];
  }
  [[nodiscard]] Eigen::Vector3f position_mm(int x, int y, int z) const {
    return origin_mm_ + spacing_mm_ * Eigen::Vector3f(static_cast<float>(x),
                                                      static_cast<float>(y),
                                                      static_cast<float>(z));
  }

 private:
  [[nodiscard]] std::size_t node_index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(x);
  }
  void seed(std::uint32_t triangle);
  void sweep(const std::array<int, 3>& direction);
  void try_triangle(std::size_t node, const Eigen::Vector3f& p, std::uint32_t triangle);

  const TriangleMesh& mesh_;
  Eigen::Vector3f origin_mm_;
  std::array<int, 3> size_;
  float spacing_mm_;
  float band_mm_;
  std::vector<std::uint32_t> triangle_;
  std::vector<float> distance_mm_;
};

}  // namespace mor::internal
