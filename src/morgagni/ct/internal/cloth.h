// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// Makes air of cloth that lies over a body: lighter than skin, a few millimetres thick and, in
/// folds, off the skin here and there. There it is recognized, and its HU are seen. Around there
/// everything from the air inwards is cloth that is nearer to its HU than to the skin's, voxel by
/// voxel: in narrow folds, behind an ear, where it lies on the skin.
///
/// @param settled  Where nothing is taken.
/// @return What was made air. Empty where no cloth is.
/// @cost 0.1 s of CPU for a head without cloth, 0.3 s for 512x512x138.
[[nodiscard]] BitMask take_cloth_off(Volume& volume, const BitMask& settled);

}  // namespace mor::internal
