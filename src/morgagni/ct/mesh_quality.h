// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// How far one surface lies from another.
struct SurfaceDistance {
  double mean_mm = 0.0;
  double p99_mm = 0.0;
  double max_mm = 0.0;
};

/// From points spread evenly over `from` (by area, fixed seed) to the nearest point of the
/// triangles of `to`. One way only: call it twice for both. Both meshes must have triangles.
/// @cost About 1 s for 200,000 points.
[[nodiscard]] SurfaceDistance surface_distance(const TriangleMesh& from,
                                               const TriangleMesh& to,
                                               int num_points);

/// Whether a mesh is what the live part may rely on.
struct MeshTopology {
  int num_open_edges = 0;          ///< Used by one triangle.
  int num_non_manifold_edges = 0;  ///< Used by more than two, or twice in one direction.
  int num_degenerate = 0;          ///< Triangles that repeat a corner or have no area.
  int num_folded_edges = 0;        ///< Whose two triangles look away from each other (> 150 deg).
  int num_unused_vertices = 0;
  int num_components = 0;
  double valence_5_to_7 = 0.0;      ///< Share of the vertices off the open borders.
  double min_angle_rad = 0.0;       ///< The smallest of all.
  double mean_min_angle_rad = 0.0;  ///< Mean over the triangles of the smallest angle.
};
[[nodiscard]] MeshTopology mesh_topology(const TriangleMesh& mesh);

}  // namespace mor
