// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The volume itself and ever coarser copies of it, each filtered before voxels are left out: rays
/// that stand farther apart than voxels would pick single ones, which looks like grain and
/// glitters while the camera moves. Axes whose voxels are the longest are left as they are until
/// the others have caught up. Voxel (0, 0, 0) is at the same place in all of them.
[[nodiscard]] std::vector<std::shared_ptr<const Volume>> make_volume_pyramid(
    std::shared_ptr<const Volume> volume, int most_levels);

}  // namespace mor::internal
