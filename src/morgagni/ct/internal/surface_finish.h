// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

struct SurfaceFinish {
  int num_triangles = 0;  ///< At most about.
  /// What the surface is to enclose; else what it encloses before, if it is closed.
  std::optional<double> volume_mm3 = {};
  std::function<void()> when_smooth = {};  ///< Called half-way, where it is given.
};

/// Makes what marching cubes left fit to be drawn: stairs smoothed, at most about `num_triangles`,
/// in an order that graphics cards like, with normals. No vertex is smoothed by more than half a
/// voxel, and the volume stays, so that thin sheets and rods do not waste away. An empty mesh stays
/// empty.
/// @param grid  That marching cubes ran on: its axes and spacing count.
void finish_surface(TriangleMesh& mesh, const Volume& grid, const SurfaceFinish& finish);

/// The same without smoothing: for a mesh that somebody else made.
void finish_given_surface(TriangleMesh& mesh, int num_triangles);

}  // namespace mor::internal
