// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "morgagni/ct/internal/lifted_sheet.h"
#include "morgagni/ct/internal/skin_profiles.h"

namespace mor::internal {

/// Where a sheet is that has a skin's HU: where it is lifted, as far as it is smooth (it may touch
/// an ear, which is as thick), and where it lies on the skin, as far as it can be told from it:
/// what is joined and looks as the sheet does. A sheet looks alike all over, skin does not. So the
/// area that is found hardly grows with what is allowed to differ, until skin begins to be taken
/// for it.
///
/// @param places  Of all profiles.
/// @return Empty: it cannot be told.
/// @cost About 0.1 s of CPU for 40,000 profiles.
[[nodiscard]] std::vector<std::size_t> sheet_places(const SkinProfiles& profiles,
                                                    const std::vector<SurfacePlace>& places,
                                                    const LiftedSheet& sheet);

}  // namespace mor::internal
