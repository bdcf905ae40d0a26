// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

struct BodyMaskOptions {
  double threshold_hu = -300.0;
  double upper_hu = 3071.0;
  double closing_mm = 3.0;
};

struct BodyMask {
  BitMask body;
  BitMask matter;  ///< All that is within the thresholds.
};

/// The body as one solid part: lungs, bowel and other air inside are filled; what only leans on the
/// body (table, headrest, blanket) is cut off.
///
/// The body is thick and what it lies on is a thin shell: an opening with a ball tears them apart.
/// What the opening takes away is given back where it is close to the body (ears, nose, fingers)
/// and not where it leads far away from it (the table).
///
/// @errors kInvalidArgument: no voxel within the thresholds; no air beside the body.
[[nodiscard]] Result<BodyMask> body_mask(const Volume& volume,
                                         const BodyMaskOptions& options,
                                         const Progress& progress);

}  // namespace mor::internal
