// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/ct/cut_part.h"
#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The parts of `mask` of 1 ml and more, the largest first, at most 20.
/// @param body  What their places are told from.
[[nodiscard]] std::vector<CutPart> parts_of(const BitMask& mask,
                                            const BitMask& body,
                                            const Volume& volume);

/// Matter that did not become body, in such parts.
[[nodiscard]] std::vector<CutPart> cut_parts(const Volume& volume, const BodyMask& body);

}  // namespace mor::internal
