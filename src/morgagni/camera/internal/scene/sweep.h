// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// One cross-section of a sweep: an ellipse, or something between the first section and it.
struct Station {
  Eigen::Vector3f center;
  float half_u_mm;
  float half_v_mm;
  float blend;  ///< 0: the first section's shape, 1: the ellipse.
};

/// A tube that begins as the closed line `start` and passes through `stations`; the last one should
/// be a point. `u` and `v` (unit, across each other) span the ellipses. Triangles face outwards
/// when `start` runs clockwise about the way of the sweep, as the edge of a skin's hole does.
/// @param start  >= 3 points. @param stations  >= 1.
[[nodiscard]] TriangleMesh sweep(const std::vector<Eigen::Vector3f>& start,
                                 const Eigen::Vector3f& u,
                                 const Eigen::Vector3f& v,
                                 const std::vector<Station>& stations);

/// Sections of a tube along a line from `begin` to `end` that closes like a ball, radius changing
/// evenly; for limbs.
[[nodiscard]] TriangleMesh tube(const Eigen::Vector3f& begin,
                                const Eigen::Vector3f& end,
                                float begin_radius_mm,
                                float end_radius_mm);

}  // namespace mor::internal
