// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/render/skin_viewpoint.h"

namespace mor {

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
