// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The soft shadow that things cast on what is below them, from the room's light above. Frame ct,
/// up is -y.
class ShadeMap {
 public:
  /// Casts no shadow.
  ShadeMap() = default;
  explicit ShadeMap(const TriangleMesh& things);

  /// How much light is left at a place, in (0, 1].
  [[nodiscard]] float light(const Eigen::Vector3f& at) const {
    return cover_.empty() ? 1.0F : light_below_things(at);
  }

 private:
  [[nodiscard]] float light_below_things(const Eigen::Vector3f& at) const;

  static constexpr float kCellMm = 8.0F;

  Eigen::Vector2f corner_mm_ = Eigen::Vector2f::Zero();  ///< x and z of the first cell.
  Image<float> cover_;      ///< Share of the cell below something, blurred.
  Image<float> height_mm_;  ///< The same times the things' lowest -y there, blurred.
};

}  // namespace mor::internal
