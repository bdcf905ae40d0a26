// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/internal/start_scene.h"
#include "morgagni/registration/internal/start_volume.h"

namespace mor::internal {

/// A place and turn of the body on a plane that may be right.
struct StartCandidate {
  double yaw_rad = 0.0;  ///< Of the picture's points about the plane's normal, then
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< along the plane: frames table to lying.
  double score = 0.0;  ///< Larger is better; comparable among candidates of one step.

  [[nodiscard]] Eigen::Isometry3d lying_from_table() const {
    return Eigen::Translation3d(shift_mm.x(), shift_mm.y(), 0.0) *
           Eigen::Isometry3d(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  }
};

/// Lays the body on the scene's plane in every place and turn of a grid, and returns the best that
/// are better than their neighbours, best first.
/// @threads Uses the calling TBB arena; the result does not depend on it.
[[nodiscard]] std::vector<StartCandidate> search_on_plane(const StartScene& scene,
                                                          const StartVolume& volume,
                                                          std::size_t max_candidates);

/// The best place and turn within a node and a yaw step of the candidate, by many points and a
/// finer volume. Unlike steps along a gradient this is not drawn away by what lies near the skin.
/// @param step_mm  Spacing of the volume that the candidate was found with.
[[nodiscard]] StartCandidate polish_on_plane(const StartScene& scene,
                                             const StartVolume& fine_volume,
                                             const StartCandidate& candidate,
                                             double step_mm);

}  // namespace mor::internal
