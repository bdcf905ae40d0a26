// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// How high what lies on the table reaches, seen from above: cells over the table's (x, z), frame
/// ct, up is -y.
class HeightMap {
 public:
  static constexpr float kCellMm = 6.0F;

  /// @param bounds  Of the body; the map reaches beyond by `margin_mm`.
  HeightMap(const Eigen::AlignedBox3f& bounds, float margin_mm, float table_top_mm);

  /// Raises the cells under the mesh to its top.
  void add(const TriangleMesh& mesh);

  /// Above the table; 0 outside of the map.
  [[nodiscard]] float height_mm(float x_mm, float z_mm) const;
  /// The place on top, and the direction away from it, judged over 24 mm.
  [[nodiscard]] Eigen::Vector3f top(float x_mm, float z_mm) const;
  [[nodiscard]] Eigen::Vector3f normal(float x_mm, float z_mm) const;

 private:
  void raise(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c);

  float table_top_mm_;
  float left_mm_;
  float foot_mm_;
  Image<float> height_mm_;
};

}  // namespace mor::internal
