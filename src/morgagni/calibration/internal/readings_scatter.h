// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "morgagni/core/image.h"

namespace mor::internal {

/// Where a picture of residuals has none.
inline constexpr float kNoResidual = std::numeric_limits<float>::max();

/// How many readings err together, so that they count as one: the sum of the residuals'
/// correlations with those of their neighbours and with those at the same place of other views.
/// @param pictures  Of residuals, one a view. @param limit  Larger ones are left out.
[[nodiscard]] double correlated_readings(const std::vector<Image<float>>& pictures, float limit);

}  // namespace mor::internal
