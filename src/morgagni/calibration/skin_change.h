// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/registration/fixed_surface.h"

namespace mor {

/// How far the body's skin lies outside of where the CT has it, along the normal: smooth, and 0 far
/// from where it was seen.
struct SkinChange {
  std::vector<Eigen::Vector3d> places_mm;  ///< Frame ct.
  std::vector<double> weights_mm;          ///< Of a Gaussian bump around each.
  double reach_mm = 1.0;                   ///< Of the bumps.

  [[nodiscard]] double at_mm(const Eigen::Vector3d& ct_mm) const;
  /// The skin as it is now. @pre It has normals.
  [[nodiscard]] TriangleMesh applied_to(TriangleMesh skin) const;
};

/// The skin as it is now, for registration. The CT's own stays as it is: what is exported of a body
/// is the CT's.
/// @param skin  With a SkinChange applied. @param words  FixedSurface::change.
/// @errors As DistanceField::build. @cost As that.
[[nodiscard]] Result<std::shared_ptr<const FixedSurface>> skin_as_found(TriangleMesh skin,
                                                                        std::string words);

}  // namespace mor
