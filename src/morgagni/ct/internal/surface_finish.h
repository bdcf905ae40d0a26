// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// Makes what marching cubes left fit to be drawn: stairs smoothed without shrinking, at most about
/// `num_triangles`, in an order that graphics cards like, with normals. An empty mesh stays empty.
/// @param when_smooth  Called half-way, where it is given.
void finish_surface(TriangleMesh& mesh,
                    int num_triangles,
                    const std::function<void()>& when_smooth = {});

/// The same without smoothing: for a mesh that somebody else made.
void finish_given_surface(TriangleMesh& mesh, int num_triangles);

}  // namespace mor::internal
