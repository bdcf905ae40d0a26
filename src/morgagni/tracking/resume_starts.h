// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/point_cloud.h"

namespace mor {

/// Where the body was when it was last seen.
struct LastSeen {
  Eigen::Isometry3d ct_from_depth;
  Eigen::Vector3d center_mm;  ///< Of the skin that was seen, frame ct.
};

/// Poses to try after a loss, nearest guess first: the last pose; the last pose with the skin that
/// was seen put where the camera sees something now; and that turned about the line of sight and
/// across it. Registration closes 30 mm / 20 deg by itself, so together they reach beyond 40 deg
/// and any shift that keeps the body in view.
///
/// @param surface  What the camera sees now, frame depth. Not empty.
/// @param round  Which axis is turned about: four turns each round, all axes in kResumeRounds.
[[nodiscard]] std::vector<Eigen::Isometry3d> resume_starts(const LastSeen& last,
                                                           const PointCloud& surface,
                                                           std::size_t round);
inline constexpr std::size_t kResumeRounds = 3;

}  // namespace mor
