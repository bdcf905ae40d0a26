// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The voxels of the body and of a little air around its skin, in the smallest box that holds them.
/// What is beside is kOutsideHu, so that no table is in the way and the file is small.
[[nodiscard]] Volume body_volume(const Volume& volume, const BitMask& body);

}  // namespace mor::internal
