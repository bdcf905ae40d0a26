// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "morgagni/registration/internal/field_alignment.h"

namespace mor::internal {

using Stages = std::span<const Stage>;

/// From a rough start to the right part of the skin, by few points. Above the skin the kernel is
/// half as wide as below: what lies above may be clutter, what seems to lie below is an error of
/// the pose. Without this a towel on a head pulls it up.
inline constexpr std::array<Stage, 5> kApproach = {{
    {{25.0F, 50.0F, 0.5F}, false, PointShare::kFew, 5, 2.0},
    {{12.5F, 25.0F, 0.5F}, false, PointShare::kFew, 5, 1.0},
    {{6.0F, 12.0F, 0.5F}, false, PointShare::kFew, 5, 0.5},
    {{6.0F, 12.0F, 0.5F}, true, PointShare::kFew, 3, 0.5},
    {{3.0F, 6.0F, 0.7F}, true, PointShare::kFew, 5, 0.1},
}};
/// A tracked start needs no more than these of them.
inline constexpr std::size_t kTrackedEntry = 2;

/// The same for skin that lies under cloth or between clutter: only what seems to lie below it
/// draws from afar, so that the pose sinks to the lowest surface that there is.
inline constexpr std::array<Stage, 5> kLowApproach = {{
    {{5.0F, 50.0F, 0.5F}, false, PointShare::kFew, 5, 1.0},
    {{4.0F, 30.0F, 0.5F}, false, PointShare::kFew, 5, 1.0},
    {{3.0F, 15.0F, 0.5F}, false, PointShare::kFew, 5, 1.0},
    {{3.0F, 15.0F, 0.5F}, true, PointShare::kFew, 5, 0.5},
    {{2.0F, 8.0F, 0.7F}, true, PointShare::kFew, 5, 0.1},
}};
/// So many stages of either approach tell where it goes.
inline constexpr std::size_t kHalfway = 3;

inline constexpr PairingRule kFinalRule = {6.0F, 6.0F, 0.7F, 2.0F, 2.0F};
/// After an approach down to the lowest part of what is seen: a thin cloth that lies on most of the
/// skin draws the pose up to a compromise, from which rows below the skin bring it back and rows
/// above do not.
inline constexpr std::array<Stage, 2> kRefinement = {{
    {{4.0F, 12.0F, 0.7F, 1.2F, 8.0F}, true, PointShare::kRuns, 12, 0.05},
    {kFinalRule, true, PointShare::kRuns, 4, 0.05},
}};
/// How a pose is judged: by rows of readings that lie along the skin to within half of a single
/// reading's noise. Cloth and clutter that a pose has settled on do not, however many they are.
inline constexpr Stage kCloseLook = {{3.0F, 3.0F, 0.7F, 0.5F, 0.5F}, true, PointShare::kRuns};
/// Last, once, by which the result is judged too. The pose is right by now, so that normals tell
/// little any more: those of ears, nose and outline are the least exact, and what lies there says
/// most about the turn of a head.
inline constexpr PairingRule kLastRule = {4.0F, 4.0F, 0.3F, 2.0F, 2.0F};
inline constexpr Stage kFinish = {kLastRule, true, PointShare::kAll, 3, 0.05};

}  // namespace mor::internal
