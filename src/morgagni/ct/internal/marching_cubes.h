// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The surface between the voxels of `inside` and the others, frame ct, vertices shared.
///
/// Marching cubes (Lorensen & Cline 1987) with the mask saying what is inside and the grey values
/// saying where between two voxels: there the HU cross `threshold_hu`, or half way where both lie
/// on one side of it (a closed gap, a cut). Open where the mask meets the volume's faces.
/// @cost Two threads by slabs; 1.2 M triangles in about 0.5 s.
[[nodiscard]] TriangleMesh marching_cubes(const Volume& volume,
                                          const BitMask& inside,
                                          double threshold_hu);

}  // namespace mor::internal
