// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// The point of the surface seen at a pixel of the colour picture.
///
/// Projects each reading into the colour camera, and averages those near the pixel that belong to
/// the surface in front: single readings are noisy and hands-on-glass is not exact.
/// @param color_pixel  In px of the colour picture.
/// @return mm, frame depth. None where the camera has no reading nearby.
/// @cost Microseconds: looks only where the pixel's ray passes.
[[nodiscard]] std::optional<Eigen::Vector3d> depth_point_at(const RgbdFrame& frame,
                                                            const Eigen::Vector2d& color_pixel);

}  // namespace mor
