// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// What lies against the body, but is of no stuff that a body has outermost: a cushion of silicone,
/// a plaster cast, a blanket. Skin, fat and hairless flesh lie between -130 and 100 HU; what
/// is lighter or denser, open to the air outside and, where it is dense, as even as no bone is,
/// does not belong to the body.
///
/// @return The covers to about a voxel, with the crust that the air leaves around them. None where
///         most of the CT would be foreign: it shows no body, but a figure of clay or dry bones.
[[nodiscard]] std::optional<BitMask> foreign_matter(const Volume& volume);

}  // namespace mor::internal
