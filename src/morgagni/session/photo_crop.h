// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

/// The part of a picture that shows these places and so much around them; the last pixel counts.
/// None: one of them is not in it.
[[nodiscard]] std::optional<Eigen::AlignedBox2i> box_around(
    const std::vector<Eigen::Vector3d>& places_ct_mm,
    const PinholeCamera& camera,
    const Eigen::Isometry3d& camera_from_ct,
    double margin_mm);

/// @param box  Within the picture.
[[nodiscard]] Image<Rgb8> cropped(ImageView<const Rgb8> picture, const Eigen::AlignedBox2i& box);
[[nodiscard]] Image<Rgb8> cropped(ImageView<const Rgba8> picture, const Eigen::AlignedBox2i& box);

/// A white ring with dark rims around a pixel, so that it is seen on any ground.
void draw_ring(ImageView<Rgb8> picture, const Eigen::Vector2d& center);

}  // namespace mor
