// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/scene_view.h"

#include <algorithm>

namespace mor {
namespace {

/// The CT skin can be shown as glass over what is inside.
constexpr const char* kSkinName = "skin";
const Eigen::Vector3f kSkinColor(0.88F, 0.68F, 0.56F);
constexpr float kSkinOpacity = 0.25F;

bool has_structure(const Case& body, const std::string& name) {
  return std::any_of(body.structures.begin(), body.structures.end(), [&](const Structure& s) {
    return s.name == name;
  });
}

std::map<std::string, float> opacities(const ViewSettings& view) {
  std::map<std::string, float> result;
  for (const auto& [name, look] : view.structures) {
    result[name] = look.is_shown ? look.opacity : 0.0F;
  }
  return result;
}

}  // namespace

RenderScene scene_of(const Case& body) {
  RenderScene scene;
  for (const auto& [name, color, mesh] : body.structures) {
    scene.structures.push_back({name, mesh, color});
  }
  if (!has_structure(body, kSkinName)) {
    scene.structures.push_back({kSkinName, body.skin->mesh, kSkinColor});
  }
  scene.skin = body.skin->mesh;
  scene.volume = body.volume;
  return scene;
}

ViewSettings first_view(const Case& body) {
  ViewSettings view;
  for (const auto& structure : body.structures) {
    const bool fills = structure.name == "lungs" || structure.name == "gas";
    view.structures[structure.name] = {!fills, 1.0F};
  }
  view.structures.try_emplace(kSkinName, StructureLook{false, kSkinOpacity});
  view.has_ct = body.volume != nullptr;
  return view;
}

OverlayView overlay_view(const RgbdFrame& frame,
                         const std::optional<Eigen::Isometry3d>& ct_from_depth,
                         const std::optional<Eigen::Isometry3d>& ct_from_ghost,
                         const ViewSettings& view,
                         bool is_still) {
  const PinholeCamera& depth_camera = frame.calibration->depth;
  const Eigen::Isometry3d& color_from_depth = frame.calibration->color_from_depth;
  OverlayView overlay;
  overlay.color_camera = frame.calibration->color;
  overlay.opacity = view.opacity;
  overlay.hole = view.hole;
  overlay.has_outlines = view.has_outlines;
  overlay.slice = view.slice;
  overlay.volume = view.volume;
  overlay.is_still = is_still;
  if (ct_from_depth) overlay.color_from_ct = color_from_depth * ct_from_depth->inverse();
  if (ct_from_ghost) overlay.color_from_ghost = color_from_depth * ct_from_ghost->inverse();
  overlay.structure_opacity = opacities(view);
  if (view.keeps_hands_in_front) {
    overlay.measured = {frame.depth_mm.view(), depth_camera, color_from_depth};
  }
  return overlay;
}

FreeView free_view(const ViewSettings& view,
                   const SkinSphere& skin,
                   int width_px,
                   int height_px,
                   const RgbdFrame* textured,
                   const std::optional<Eigen::Isometry3d>& ct_from_depth) {
  const SkinViewpoint viewpoint{.yaw_rad = view.free.yaw_rad,
                                .pitch_rad = view.free.pitch_rad,
                                .zoom = view.free.zoom,
                                .width_px = width_px,
                                .height_px = height_px,
                                .target_mm = view.free.target_mm};
  FreeView free;
  free.camera = view_camera(viewpoint);
  free.view_from_ct = view_from_ct(viewpoint, skin);
  free.shows_bare_skin = view.free.shows_bare_skin;
  free.structure_opacity = opacities(view);
  free.structure_opacity[kSkinName] = 0.0F;  // It is there in colours.
  if (textured == nullptr || !ct_from_depth) return free;
  const PinholeCamera& depth_camera = textured->calibration->depth;
  const Eigen::Isometry3d& color_from_depth = textured->calibration->color_from_depth;
  free.picture = {.color = textured->color.view(),
                  .camera = textured->calibration->color,
                  .color_from_ct = color_from_depth * ct_from_depth->inverse()};
  if (view.keeps_hands_in_front) {
    free.picture->measured = {textured->depth_mm.view(), depth_camera, color_from_depth};
  }
  if (view.free.opens_hole) free.picture->hole = view.hole;
  return free;
}

}  // namespace mor
