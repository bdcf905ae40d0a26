// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// The CT as it would be without a cover: air where it was, and in the voxels that it shares with
/// the skin air in the same share, so that the skin lies where it would lie bare.
///
/// A voxel between cover and skin holds as much cover as its HU lies on the way from the skin's HU
/// (the densest beside it) to the cover's (its mean around there).
///
/// @param cover  Within a voxel or so.
/// @param cover_hu  Of all the cover, where it is known; or its mean around a place is taken.
[[nodiscard]] Volume uncovered(const Volume& volume,
                               const BitMask& cover,
                               std::optional<double> cover_hu = std::nullopt);

/// A CT without what lies on the body, and what is not known for certain because of it. The masks
/// reach 2.2 mm beyond what they are of; they have no voxels where the CT shows no body.
struct BareCt {
  std::optional<Volume> volume;  ///< None: nothing lies on the body.
  BitMask cover;                 ///< What foreign_matter() finds.
  BitMask layer;                 ///< Thin layers that were taken off (peel()).
  BitMask tube;                  ///< Of these, tubes.
  BitMask asked;                 ///< Where one was taken off because somebody asked for it.
  BitMask unknown;               ///< Surface where a thin layer may go on unseen.
  double most_unknown_mm = 0.0;  ///< ... of at most this thickness.
};

/// @param take_off_mm  SkinOptions::take_off_mm.
/// @param report  Told the share that is done.
[[nodiscard]] BareCt bare_ct(const Volume& volume,
                             const std::vector<Eigen::Vector3d>& take_off_mm = {},
                             const std::function<void(double)>& report = {});

}  // namespace mor::internal
