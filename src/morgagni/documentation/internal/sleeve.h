// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

/// A mesh and who lies behind the edge from corner i to the next of each of its triangles.
struct LinkedMesh {
  const TriangleMesh& mesh;
  std::span<const std::array<std::uint32_t, 3>> neighbors;
};

/// Where a way through a row of triangles bends.
struct Bend {
  std::uint32_t vertex = 0;
  std::size_t portal = 0;  ///< One of the edges of the row that end at the vertex.
};

/// The shortest way through a row of triangles, each next one a neighbour of the one before.
struct SleevePath {
  double length_mm = 0.0;
  std::vector<Bend> bends;
  std::vector<Eigen::Vector3d> points_mm;  ///< Both ends, and a point of each edge between.
};

/// @param row  From the triangle of `from` to that of `to`.
[[nodiscard]] SleevePath path_in_sleeve(const LinkedMesh& linked,
                                        const std::vector<std::uint32_t>& row,
                                        const Eigen::Vector3d& from,
                                        const Eigen::Vector3d& to);

/// The row led around the other side of the vertex of a bend. Empty: the surface ends there.
[[nodiscard]] std::vector<std::uint32_t> around_other_side(const LinkedMesh& linked,
                                                           const std::vector<std::uint32_t>& row,
                                                           const Bend& bend);

}  // namespace mor::internal
