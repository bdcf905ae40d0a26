// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// Every second voxel along the axes whose voxels are smaller than `small_mm`; the first stays
/// where it is.
[[nodiscard]] Volume coarse_volume(const Volume& volume, double small_mm);

}  // namespace mor::internal
