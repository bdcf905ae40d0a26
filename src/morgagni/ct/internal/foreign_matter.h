// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// What lies against the body and is as thick as a limb, but of no stuff that a body has outermost:
/// a cushion of silicone, a plaster cast, a folded blanket. Skin, fat and hairless flesh lie
/// between -160 and 100 HU; what is lighter or denser, about 6 mm thick, open to the air outside
/// and, where it is dense, as even as no bone is, does not belong to the body.
///
/// @param matter  All that is within the thresholds. Where most of it would be foreign (a figure of
///                terracotta, dry bones), nothing is.
/// @return Voxels of `matter`, with the crust that the air leaves around them.
[[nodiscard]] BitMask foreign_matter(const Volume& volume, const BitMask& matter);

}  // namespace mor::internal
