// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/render/free_view.h"
#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/skin_viewpoint.h"
#include "morgagni/session/view_settings.h"

namespace mor {

/// What of a case the renderer draws: its structures, its skin, its CT.
[[nodiscard]] RenderScene scene_of(const Case& body);

/// The view that a case begins with: its structures in a hole in the middle, but for the skin and
/// what fills the body (lungs, gas), which would hide the rest.
[[nodiscard]] ViewSettings first_view(const Case& body);

/// What the user wants to see, on this frame at this pose.
/// @param frame  Must outlive the result, which looks at its depth picture.
/// @param is_still  The picture is frozen: drawn as well as can be, however long that takes.
[[nodiscard]] OverlayView overlay_view(const RgbdFrame& frame,
                                       const std::optional<Eigen::Isometry3d>& ct_from_depth,
                                       const std::optional<Eigen::Isometry3d>& ct_from_ghost,
                                       const ViewSettings& view,
                                       bool is_still);

/// The free view of a picture of that size.
/// @param textured  The frame whose colours the skin wears, and its pose; null: it has none yet.
/// Must outlive the result, which looks at its pictures.
[[nodiscard]] FreeView free_view(const ViewSettings& view,
                                 const SkinSphere& skin,
                                 int width_px,
                                 int height_px,
                                 const RgbdFrame* textured,
                                 const std::optional<Eigen::Isometry3d>& ct_from_depth);

}  // namespace mor
