// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::testing_mesh {

/// A box, its corners counter-clockwise from outside. Each face's diagonal is chosen without care,
/// so corners meet different numbers of triangles.
inline TriangleMesh make_box(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  TriangleMesh mesh;
  for (unsigned corner = 0; corner < 8; ++corner) {
    mesh.vertices.emplace_back(corner & 1U ? high.x() : low.x(),
                               corner & 2U ? high.y() : low.y(),
                               corner & 4U ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 1},
                    {1, 2, 3},
                    {4, 5, 6},
                    {5, 7, 6},
                    {0, 1, 4},
                    {1, 5, 4},
                    {2, 6, 3},
                    {3, 6, 7},
                    {0, 4, 2},
                    {2, 4, 6},
                    {1, 3, 5},
                    {3, 7, 5}};
  return mesh;
}

}  // namespace mor::testing_mesh
