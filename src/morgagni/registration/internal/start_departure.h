// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/image.h"

namespace mor::internal {

/// How many pixels the measured surface departs on from the skin: runs on without an edge from
/// where it lies on the skin to where it stands before it. A hand or a towel on the skin has an
/// edge; a body that only touches the CT's in a wrong pose has none.
///
/// @param misfit  Measured less expected depth in tolerances, NaN where there is nothing to
/// compare:
///        within -1..1 is on the skin, below hides it.
[[nodiscard]] int count_departing(const Image<float>& misfit);

}  // namespace mor::internal
