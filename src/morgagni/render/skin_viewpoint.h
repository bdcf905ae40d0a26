// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Where a virtual camera stands that looks at the CT skin.
struct SkinViewpoint {
  double yaw_rad = 0.0;  ///< Around the body's long axis; 0: from the front (anterior), pi/2: from
                         ///< the body's left.
  double pitch_rad = 0.0;  ///< Up towards the head; 0: level.
  double zoom = 1.0;       ///< 1: the whole skin fits. > 0.
  int width_px = 640;
  int height_px = 480;
  /// What is in the middle of the picture and turned about, from the skin's middle, frame ct.
  Eigen::Vector3d target_mm = Eigen::Vector3d::Zero();
};

/// Around all of the skin.
struct SkinSphere {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_mm = 1.0;
};

[[nodiscard]] SkinSphere bounding_sphere(const TriangleMesh& skin);

/// The virtual camera, without distortion. At zoom 1 the sphere fills most of the shorter side.
[[nodiscard]] PinholeCamera view_camera(const SkinViewpoint& viewpoint);

[[nodiscard]] Eigen::Isometry3d view_from_ct(const SkinViewpoint& viewpoint,
                                             const SkinSphere& skin);

}  // namespace mor
