// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/internal/random.h"
#include "morgagni/camera/internal/scene/painted_mesh.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The edge of a hole in a surface: a closed line of points.
struct BoundaryLoop {
  std::vector<Eigen::Vector3f> points;  ///< In the order of the triangles beside it.
  float length_mm = 0.0F;
  Eigen::Vector3f center;
  Eigen::Vector3f outward;  ///< Unit: out of the hole, where the body would go on.
};

/// Loops of at least `least_length_mm`, the longest first.
[[nodiscard]] std::vector<BoundaryLoop> boundary_loops(const TriangleMesh& mesh,
                                                       float least_length_mm);

/// The body where the CT ends: smooth solids that begin at the skin's cut edges and take drawn
/// shapes beyond. A broad body (wider than 280 mm) gets a neck, a head and arms at its upper end, a
/// belly and thighs at its lower; a head gets a crown, a neck and shoulders; other cuts get stumps.
class BodyBeyond {
 public:
  /// @param skin  Frame ct, LPS, supine.
  BodyBeyond(const TriangleMesh& skin, float table_top_mm);

  /// Empty for a closed skin.
  [[nodiscard]] PaintedMesh continued(Draws& draw) const;

 private:
  [[nodiscard]] TriangleMesh above_broad(const BoundaryLoop& loop, Draws& draw) const;
  [[nodiscard]] TriangleMesh below_broad(const BoundaryLoop& loop, Draws& draw) const;
  [[nodiscard]] TriangleMesh below_head(const BoundaryLoop& loop, Draws& draw) const;

  std::vector<BoundaryLoop> loops_;
  Eigen::AlignedBox3f bounds_;
  float table_top_mm_;
};

}  // namespace mor::internal
