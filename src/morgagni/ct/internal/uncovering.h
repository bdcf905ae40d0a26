// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The CT as it would be without a cover: air where it was, and in the voxels that it shares with
/// the skin air in the same share, so that the skin lies where it would lie bare.
///
/// A voxel between cover and skin holds as much cover as its HU lies on the way from the skin's HU
/// (the densest beside it) to the cover's (its mean around there).
///
/// @param cover  Within a voxel or so.
[[nodiscard]] Volume uncovered(const Volume& volume, const BitMask& cover);

/// The same of all that foreign_matter() finds. None where that is nothing.
[[nodiscard]] std::optional<Volume> without_covers(const Volume& volume);

}  // namespace mor::internal
