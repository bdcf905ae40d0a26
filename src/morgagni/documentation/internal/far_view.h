// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// A camera so far off that perspective hardly shows, with the whole body in its picture.
struct FarView {
  /// @param from  Unit vector from the body to the camera, frame ct. The head's end is up.
  FarView(const Eigen::AlignedBox3f& bounds, const Eigen::Vector3d& from, int width, int height);

  PinholeCamera camera;
  Eigen::Isometry3d view_from_ct;
};

}  // namespace mor::internal
