// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// HU that tell tissues apart; below and above them differences say little of where things lie.
inline constexpr std::int16_t kLeastTissueHu = -300;
inline constexpr std::int16_t kMostTissueHu = 500;

/// The body alone on cubes of a given size along LPS, clamped to [kLeastTissueHu, kMostTissueHu]:
/// what lies around the body need not move with it. Means of the voxels in a cube.
[[nodiscard]] Volume body_block(const Volume& volume, double cube_mm);

}  // namespace mor::internal
