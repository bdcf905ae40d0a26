// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/image.h"

/// Of a body's skin in slices, for body.png and the check page.
namespace mor::internal {

inline constexpr Rgb8 kOutline = {60, 230, 100};
inline constexpr Rgb8 kDoubtful = {255, 150, 30};  ///< Where it is not certain.

}  // namespace mor::internal
