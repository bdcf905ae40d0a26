// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/image.h"
#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// A picture to judge the cut by: three slices, a front and a side view. The body is grey with a
/// green outline, orange where the skin is doubtful, what was cut off is red.
[[nodiscard]] Image<Rgb8> draw_body_preview(const Volume& volume,
                                            const BitMask& matter,
                                            const BitMask& body,
                                            const BitMask& doubtful);

}  // namespace mor::internal
