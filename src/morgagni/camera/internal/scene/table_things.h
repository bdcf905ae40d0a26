// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/camera/internal/random.h"
#include "morgagni/camera/internal/scene/painted_mesh.h"

namespace mor::internal {

/// What stands on the table beside the body: a tray with instruments, a bottle, blocks that hold
/// the upper end of the body on either side. Drawn places and sizes, never inside `body`.
/// @param body  Bounds of the skin, frame ct.
[[nodiscard]] PaintedMesh table_things(const Eigen::AlignedBox3f& body,
                                       float table_top_mm,
                                       Draws& draw);

}  // namespace mor::internal
