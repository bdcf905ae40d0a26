// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

namespace mor {

using Triangle = std::array<std::uint32_t, 3>;

/// A surface of triangles: vertices in mm, corners counter-clockwise seen from outside.
/// `normals` has one unit vector a vertex, or is empty.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3f> normals;
  std::vector<Triangle> triangles;

  [[nodiscard]] bool empty() const { return triangles.empty(); }
  [[nodiscard]] Eigen::AlignedBox3f bounds() const;
};

/// Unit normals weighted by the triangles' angles at the vertex (Thurmer & Wuthrich 1998); a vertex
/// without a proper triangle gets +z.
[[nodiscard]] std::vector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh);

/// Sum of the triangles' areas, mm^2.
[[nodiscard]] double surface_area_mm2(const TriangleMesh& mesh);

}  // namespace mor
