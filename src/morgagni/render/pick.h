// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "morgagni/render/overlay_renderer.h"

namespace mor {

enum class PickedThing : std::uint8_t { kSkin, kStructure, kSlice, kVolume };

/// What a picture shows at a pixel.
struct PickedPoint {
  Eigen::Vector3d ct_mm = Eigen::Vector3d::Zero();
  PickedThing thing = PickedThing::kSkin;
  std::string structure;  ///< kStructure: its name.
  /// Cosine between the surface's normal and the way to the camera, 0..1; 1 where the thing has no
  /// surface. The smaller, the farther an error across the picture carries along the surface.
  double facing = 1.0;
};

/// What is seen at a pixel: in the hole the nearest of the layers that are shown, elsewhere, and
/// where the hole shows nothing, the skin. The skin as a glass layer does not count.
/// @param view  As the picture was drawn; its measured depth is not looked at.
/// @return None beside the body, outside of the picture, without a pose.
/// @threads Reentrant. @cost Milliseconds: every triangle is tried.
[[nodiscard]] std::optional<PickedPoint> pick_point(const RenderScene& scene,
                                                    const OverlayView& view,
                                                    const Eigen::Vector2d& pixel);

}  // namespace mor
