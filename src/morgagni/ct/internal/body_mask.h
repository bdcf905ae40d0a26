// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/ct/internal/uncovering.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

struct BodyMaskOptions {
  double threshold_hu = -300.0;
  double upper_hu = 3071.0;
  double closing_mm = 3.0;
  std::vector<Eigen::Vector3d> keep_mm = {};  ///< In parts that are kept though they would be cut.
  std::vector<Eigen::Vector3d> cut_mm = {};   ///< In parts that stand out and are cut all the same.
};

struct BodyMask {
  BitMask body;
  BitMask matter;  ///< All that is within the thresholds.
  /// What is cut and what stands out when nobody marks anything: marks name parts of these two.
  BitMask found_cut;           ///< Matter beside the body.
  BitMask found_standing_out;  ///< Of the body: ears, nose, fingers.
};

/// The body as one solid part: lungs, bowel and other air inside are filled; what only leans on the
/// body (table, headrest, blanket) is cut off.
///
/// The body is thick and what it lies on is a thin shell: an opening with a ball tears them apart.
/// What the opening takes away is given back where it is close to the body (ears, nose, fingers)
/// and not where it leads far away from it (the table).
///
/// A part that a mark of `keep_mm` lies in is kept even where it does not touch the body (an arm).
///
/// @param bare  The CT without the covers that touch the skin (bare_ct()): the skin lies at the
///              threshold in it. Small parts that a tube was taken off beside are not given back.
/// @errors kInvalidArgument: no voxel within the thresholds; no air beside the body; a mark
///         with no part there.
[[nodiscard]] Result<BodyMask> body_mask(const Volume& volume,
                                         const BareCt& bare,
                                         const BodyMaskOptions& options,
                                         const Progress& progress);

/// Whether `mask` has a voxel where a mark at this place would find it.
[[nodiscard]] bool is_near(const BitMask& mask,
                           const Eigen::Vector3d& place_mm,
                           const Volume& volume);

}  // namespace mor::internal
