// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "morgagni/geometry/volume.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/overlay_view.h"

namespace mor::internal {

/// Where a slice lies, colour frame, its normal away from the camera.
/// @param skin_mm  z of the skin at the hole's centre, which the camera's plane counts from; 0:
/// unknown, it counts from the body's nearest corner.
[[nodiscard]] std::optional<Eigen::Hyperplane<double, 3>> slice_plane(
    const SliceView& slice,
    const Volume& volume,
    const Eigen::Isometry3d& color_from_ct,
    double skin_mm);

/// The CT's grey values on the plane, within the body. @param layer  Of the box that it has.
void draw_slice(const SliceView& slice,
                const Eigen::Hyperplane<double, 3>& plane,
                const Volume& volume,
                const Eigen::Isometry3d& color_from_ct,
                const PictureRays& rays,
                Layer& layer);

}  // namespace mor::internal
