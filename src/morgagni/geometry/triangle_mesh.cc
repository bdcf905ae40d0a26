// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>

namespace mor {

Eigen::AlignedBox3f TriangleMesh::bounds() const {
  Eigen::AlignedBox3f box;
  for (const auto& vertex : vertices) box.extend(vertex);
  return box;
}

std::vector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& corners : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3f& here = mesh.vertices[corners[i]];
      const Eigen::Vector3f to_next = mesh.vertices[corners[(i + 1) % 3]] - here;
      const Eigen::Vector3f to_last = mesh.vertices[corners[(i + 2) % 3]] - here;
      const Eigen::Vector3f cross = to_next.cross(to_last);
      const float sine = cross.norm();
      if (sine > 0.0F)
        normals[corners[i]] += cross * (std::atan2(sine, to_next.dot(to_last)) / sine);
    }
  }
  for (auto& normal : normals) {
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
  return normals;
}

double surface_area_mm2(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f ab = mesh.vertices[b] - mesh.vertices[a];
    const Eigen::Vector3f ac = mesh.vertices[c] - mesh.vertices[a];
    area += 0.5 * static_cast<double>(ab.cross(ac).norm());
  }
  return area;
}

}  // namespace mor
