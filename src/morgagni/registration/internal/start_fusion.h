// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/registration/internal/start_picture.h"

namespace mor::internal {

/// The picture, each reading the mean of what all of them measured at its place: less noise from
/// the same place. What another one sees there on another surface does not count.
/// @cost About 1 ms a picture.
[[nodiscard]] StartPicture fused(const StartPicture& picture,
                                 const std::vector<OtherPicture>& others);

}  // namespace mor::internal
