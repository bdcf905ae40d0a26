// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/internal/start_picture.h"

namespace mor::internal {

/// How the camera moved between two pictures of a scene that stands still: everything in them
/// counts, body, table and clutter alike.
///
/// Point-to-plane Gauss-Newton (Chen & Medioni, "Object modelling by registration of multiple range
/// images", 1992) from standing still, pairs by projection into the earlier picture (Blais &
/// Levine, "Registering multiview range data to create 3D computer objects", 1995), with Tukey's
/// kernel annealed: good for motions of some 50 mm and 6 degrees.
///
/// @param others  Pictures before the earlier one, as seen from there. They take part in the last
///                steps, so that errors do not add up from picture to picture.
/// @return earlier_from_later. None where too little of the later picture is seen in the earlier
///         one where it should be, or what is seen does not settle the motion (a bare
///         table).
/// @cost About 10 ms.
[[nodiscard]] std::optional<Eigen::Isometry3d> camera_motion(
    const StartPicture& earlier,
    const StartPicture& later,
    const std::vector<OtherPicture>& others = {});

}  // namespace mor::internal
