// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/volume.h"

namespace mor {

/// How well two CTs of one body agree where both show it.
struct OverlapQuality {
  double overlap_mm = 0.0;   ///< Along the body.
  double correlation = 0.0;  ///< Of the HU of the body, -1..1.
  /// By how much pieces of 30 mm lie off when each is moved to where it fits best.
  double median_offset_mm = 0.0;
  double p90_offset_mm = 0.0;
  int num_pieces = 0;
  double hu_difference = 0.0;  ///< Median of soft tissue, second against first.
};

struct AlignedVolumes {
  Eigen::Isometry3d first_from_second = Eigen::Isometry3d::Identity();  ///< Of their frames ct.
  OverlapQuality quality;
};

/// Measures the overlap of two CTs at a given pose.
/// @errors kInvalidArgument: they have less than 20 mm of the body in common.
[[nodiscard]] Result<OverlapQuality> overlap_quality(const Volume& first,
                                                     const Volume& second,
                                                     const Eigen::Isometry3d& first_from_second);

/// Finds where the second CT lies to the first from the part of the body that both show, moved and
/// turned: shifted tables, feet first, turned over. Never mirrored. Every shift along the body that
/// leaves 40 mm in common is tried; the best are refined on the HU (Gauss-Newton).
/// @errors kInvalidArgument: nothing fits, or two places fit nearly as well; with the figures.
/// @cost About 3 s of CPU for two halves of 512x512x275.
[[nodiscard]] Result<AlignedVolumes> align_volumes(const Volume& first,
                                                   const Volume& second,
                                                   const Progress& progress);

}  // namespace mor
