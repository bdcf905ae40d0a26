// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/image.h"

namespace mor::internal {

/// How evenly what is measured lies on the skin, over patches of 4x4 pixels. A reading's noise is
/// gone from a patch's mean, so that at the right pose the means are all near nothing; skin that
/// only looks alike, as at a wrong pose, is off by a millimetre here and there.
struct Evenness {
  int num_patches = 0;  ///< Wholly or nearly so on the skin.
  /// Root mean square of the patches' means, less an error that changes slowly over the picture:
  /// such is the sensor's own.
  double uneven_mm = 0.0;
};

/// @param misfit_mm  Measured less expected depth, NaN where there is nothing to compare or where
/// it is not the skin that is measured.
[[nodiscard]] Evenness judge_evenness(const Image<float>& misfit_mm);

}  // namespace mor::internal
