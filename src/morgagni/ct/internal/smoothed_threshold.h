// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// Voxels of `within` with low_hu <= HU < high_hu, each together with the six beside it, which
/// count as much as it does: the noise of one must not count.
[[nodiscard]] BitMask smoothed_threshold(const Volume& volume,
                                         const BitMask& within,
                                         double low_hu,
                                         double high_hu);

}  // namespace mor::internal
