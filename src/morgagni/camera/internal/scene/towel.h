// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/camera/internal/random.h"
#include "morgagni/camera/internal/scene/height_map.h"
#include "morgagni/camera/internal/scene/painted_mesh.h"

namespace mor::internal {

/// A towel of drawn size and colour over one end or side of `area` (x, z of the frame ct). It lies
/// some millimetres over what carries it, falls off no steeper than cloth does, spans what is
/// hollow, and has folds of up to a centimetre.
[[nodiscard]] PaintedMesh draped_towel(const Eigen::AlignedBox2f& area,
                                       const HeightMap& ground,
                                       float table_top_mm,
                                       Draws& draw);

}  // namespace mor::internal
