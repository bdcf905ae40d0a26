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
  float share = 0.0F;  ///< Of the surface seen in the picture, 0..1.

  [[nodiscard]] float height_mm(const Eigen::Vector3f& p) const {
    return normal.dot(p) - offset_mm;
  }
};

/// The picture's largest planes, largest first, at most four. A table is among them where enough
/// of it is seen; so may be a floor, a wall, a folded towel.
/// @param up  Opposite to gravity, unit, where known: other planes are left out.
[[nodiscard]] std::vector<StartPlane> find_planes(const StartPicture& picture,
                                                  const std::optional<Eigen::Vector3f>& up);

}  // namespace mor::internal
