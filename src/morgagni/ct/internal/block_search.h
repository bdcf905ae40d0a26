// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// Places of the second block to the first that are worth refining, the most promising first: every
/// shift along z, in x and y by the bodies' middles there, each in six quarter and half turns.
/// @param first, second  Of body_block(), with cubes of one size.
[[nodiscard]] std::vector<Eigen::Isometry3d> search_blocks(const Volume& first,
                                                           const Volume& second);

}  // namespace mor::internal
