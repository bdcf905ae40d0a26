// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/internal/start_scene.h"
#include "morgagni/registration/internal/start_volume.h"

namespace mor::internal {

/// A pose that may be right.
struct StartCandidate {
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  double score = 0.0;  ///< Larger is better; comparable among candidates of one step.
};

/// Lays the body on the scene's plane in every place and turn of a grid, and returns the best that
/// are better than their neighbours, best first.
/// @threads Uses the calling TBB arena; the result does not depend on it.
[[nodiscard]] std::vector<StartCandidate> search_on_plane(const StartScene& scene,
                                                          const StartVolume& volume,
                                                          std::size_t max_candidates);

}  // namespace mor::internal
