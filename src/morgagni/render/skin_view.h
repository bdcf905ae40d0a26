// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Where a virtual camera stands that looks at the middle of the CT skin.
struct SkinViewpoint {
  double yaw_rad = 0.0;  ///< Around the body's long axis; 0: from the front (anterior), pi/2: from
                         ///< the body's left.
  double pitch_rad = 0.0;  ///< Up towards the head; 0: level.
  double zoom = 1.0;       ///< 1: the whole skin fits. > 0.
  int width_px = 640;
  int height_px = 480;
};

/// A picture of the CT skin and what is under each of its pixels: the page's view on which
/// landmarks are tapped.
struct SkinView {
  Image<Rgb8> picture;
  PinholeCamera camera;
  Eigen::Isometry3d view_from_ct = Eigen::Isometry3d::Identity();
  Image<float> depth_mm;  ///< 0 where the background is.

  /// The CT point seen at a pixel, LPS mm. None on the background or outside of the picture.
  [[nodiscard]] std::optional<Eigen::Vector3d> ct_point(const Eigen::Vector2d& pixel) const;
};

/// Drawn on the CPU, lit from the viewer: any thread, no GL. @cost About 40 ms at 640x480.
[[nodiscard]] SkinView draw_skin_view(const TriangleMesh& skin, const SkinViewpoint& viewpoint);

}  // namespace mor
