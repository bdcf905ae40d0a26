// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "morgagni/ct/internal/bit_mask.h"

namespace mor::internal {

/// The voxels of `part` that belong to a thin, smooth sheet on its outer side, seen from `middle`:
/// the shell of a headrest that an ear touches. Where something thicker lies against the sheet from
/// within, the sheet is carried on through it as its neighbourhood bends.
///
/// @param part    What an opening tore off the body; only sheets across x and y are found.
/// @param middle  In the body, in voxels.
/// @return Empty where there is no sheet of some size.
[[nodiscard]] BitMask thin_sheet(const BitMask& part,
                                 const Eigen::Vector3d& middle,
                                 const Eigen::Vector3d& spacing_mm);

}  // namespace mor::internal
