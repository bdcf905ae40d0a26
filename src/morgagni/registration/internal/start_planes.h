// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "morgagni/registration/internal/start_picture.h"

namespace mor::internal {

/// A plane in the picture, frame depth; the camera is above it.
struct StartPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  ///< Unit, up.
  float offset_mm = 0.0F;
  float share = 0.0F;        ///< Of the surface seen in the picture, 0..1.
  bool is_supposed = false;  ///< Not seen: only its direction is known.

  [[nodiscard]] float height_mm(const Eigen::Vector3f& p) const {
    return normal.dot(p) - offset_mm;
  }
};

/// The picture's largest planes, largest first, at most four. A table is among them where enough
/// of it is seen; so may be a floor, a wall, a folded towel.
/// @param up  Opposite to gravity, unit, where known: other planes are left out.
[[nodiscard]] std::vector<StartPlane> find_planes(const StartPicture& picture,
                                                  const std::optional<Eigen::Vector3f>& up);

/// Whether a point of the picture is within `reach_mm` of a plane that much of the picture lies in.
[[nodiscard]] bool is_in_large_plane(const std::vector<StartPlane>& planes,
                                     const Eigen::Vector3f& p,
                                     float reach_mm);

/// Of the picture's readings, those up to `reach_mm` below the plane, 0..1.
[[nodiscard]] float share_below(const StartPicture& picture,
                                const StartPlane& plane,
                                float reach_mm);

/// Level planes at all heights, `step_mm` apart, at which a table that is not seen may carry a body
/// of this height, if its upper parts are the highest things seen.
/// @param up  Opposite to gravity, unit.
[[nodiscard]] std::vector<StartPlane> suppose_planes(const StartPicture& picture,
                                                     const Eigen::Vector3f& up,
                                                     float body_height_mm,
                                                     float step_mm);

}  // namespace mor::internal
