// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/ct/internal/uncovering.h"
#include "morgagni/ct/skin_doubt.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

struct DoubtfulSkin {
  std::vector<SkinDoubt> stretches;  ///< Of 3 cm2 and more, the largest first, at most 20.
  BitMask where;                     ///< The surface voxels of them all, and those around.
};

/// Where a body's skin lies at what was taken off, or near to what may go on unseen.
[[nodiscard]] DoubtfulSkin doubtful_skin(const BareCt& bare,
                                         const BitMask& body,
                                         const Volume& volume);

}  // namespace mor::internal
