// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// How deep a camera sees into the skin: a point of the skin is seen where it is nearer than this.
///
/// Not the skin's own depth, as in a shadow map, but half way between where its outer side is seen
/// and where the ray leaves the body again: a point that is seen lies before it by half of what the
/// body is thick, however much the skin turns away, and one behind another part by half of that
/// part and the air between (Woo 1992). So nothing has to be set off by a bias, which would have
/// points hide themselves at grazing angles or colours reach behind an edge.
class SeenDepth {
 public:
  /// @param camera  Its distortion is left to the one who projects: this is a pinhole's picture
  /// that holds all rays of the camera's.
  void update(const TriangleMesh& skin,
              const PinholeCamera& camera,
              const Eigen::Isometry3d& camera_from_ct);

  [[nodiscard]] const PinholeCamera& camera() const { return camera_; }
  /// z in the camera frame; kNothingThere beside the skin.
  [[nodiscard]] const Image<float>& limit_mm() const { return limit_mm_; }

  static constexpr float kNothingThere = 1e6F;

 private:
  PinholeCamera source_;  ///< Whose rays `camera_` holds.
  PinholeCamera camera_;
  Image<float> limit_mm_;
};

}  // namespace mor::internal
