// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/view_checks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

tl::unexpected<Error> refuse(const std::string& sentence) {
  return make_error(ErrorCode::kInvalidArgument, sentence);
}

Result<void> check_share(const std::string& name, float value) {
  if (value >= 0.0F && value <= 1.0F) return {};
  return refuse(fmt::format("{} must be in [0, 1], got {}", name, value));
}

Result<void> check_measured(const MeasuredDepth& measured) {
  MOR_CHECK(measured.depth_camera.check());
  if (measured.depth_mm.width() != measured.depth_camera.width_px ||
      measured.depth_mm.height() != measured.depth_camera.height_px) {
    return refuse(fmt::format("the depth picture is {} x {} px, its camera {} x {} px",
                              measured.depth_mm.width(),
                              measured.depth_mm.height(),
                              measured.depth_camera.width_px,
                              measured.depth_camera.height_px));
  }
  if (!measured.color_from_depth.matrix().allFinite()) {
    return refuse("the way from the depth to the colour camera must be finite numbers");
  }
  return {};
}

Result<void> check_slice(const SliceView& slice) {
  if (slice.plane == SlicePlane::kNone) return {};
  MOR_CHECK(check_share("the slice's position", slice.position));
  MOR_CHECK(check_share("the slice's opacity", slice.opacity));
  if (!(slice.depth_mm >= 0.0F && std::isfinite(slice.depth_mm))) {
    return refuse(fmt::format("the slice's depth must be at least 0 mm, got {}", slice.depth_mm));
  }
  if (!std::isfinite(slice.level_hu) || !std::isfinite(slice.window_hu) ||
      slice.window_hu == 0.0F) {
    return refuse(fmt::format("the slice's window must be a width in HU other than 0, got {} at {}",
                              slice.window_hu,
                              slice.level_hu));
  }
  return {};
}

Result<void> check_volume_view(const VolumeView& volume) {
  if (volume.preset == VolumePreset::kNone) return {};
  if (std::isfinite(volume.level_hu) && std::isfinite(volume.window_hu) &&
      volume.window_hu > 0.0F) {
    return {};
  }
  return refuse(fmt::format("the volume's window must be wider than 0 HU, got {} at {}",
                            volume.window_hu,
                            volume.level_hu));
}

Result<void> check_size(ImageView<const Rgb8> color, const PinholeCamera& camera) {
  MOR_CHECK(camera.check());
  if (color.width() == camera.width_px && color.height() == camera.height_px) return {};
  return refuse(fmt::format("the colour picture is {} x {} px, its camera {} x {} px",
                            color.width(),
                            color.height(),
                            camera.width_px,
                            camera.height_px));
}

Result<void> check_hole(const Hole& hole) {
  if (hole.center.allFinite() && std::isfinite(hole.radius) && std::isfinite(hole.rim)) return {};
  return refuse("the hole's centre, radius and rim must be finite numbers");
}

Result<void> check_opacities(const std::map<std::string, float>& opacities) {
  for (const auto& [name, opacity] : opacities) {
    MOR_CHECK(check_share("the opacity of " + name, opacity));
  }
  return {};
}

Result<void> check_pose(const Eigen::Isometry3d& pose) {
  if (pose.matrix().allFinite()) return {};
  return refuse("a pose to draw at must be finite numbers");
}

/// The corners of an atlas's mesh, and its picture.
Result<void> check_atlas(const AtlasPicture& atlas) {
  if (!atlas.surface || !atlas.colors) return refuse("an atlas needs a surface and a picture");
  const AtlasSurface& surface = *atlas.surface;
  MOR_CHECK(check_mesh("the atlas", surface.mesh));
  if (surface.mesh.normals.size() != surface.mesh.vertices.size() ||
      surface.corners_px.size() != surface.mesh.triangles.size()) {
    return refuse(
        fmt::format("the atlas has {} normals for {} vertices, {} corners for {} triangles",
                    surface.mesh.normals.size(),
                    surface.mesh.vertices.size(),
                    surface.corners_px.size(),
                    surface.mesh.triangles.size()));
  }
  if (atlas.colors->width() != surface.width_px || atlas.colors->height() != surface.height_px ||
      atlas.colors->empty()) {
    return refuse(fmt::format("the atlas is {} x {} px, its picture {} x {} px",
                              surface.width_px,
                              surface.height_px,
                              atlas.colors->width(),
                              atlas.colors->height()));
  }
  return {};
}

}  // namespace

Result<void> check_volume(const Volume& volume) {
  const bool is_thick =
      std::all_of(volume.size.begin(), volume.size.end(), [](int side) { return side >= 2; });
  if (is_thick && volume.num_voxels() == volume.index(0, 0, volume.size[2])) return {};
  return refuse(fmt::format("a CT to be drawn needs two voxels a side, got {} x {} x {}",
                            volume.size[0],
                            volume.size[1],
                            volume.size[2]));
}

Result<void> check_mesh(const std::string& name, const TriangleMesh& mesh) {
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    if (!vertex.allFinite()) {
      return refuse(fmt::format("the mesh of {} has a vertex that is not finite", name));
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    const auto largest = *std::max_element(triangle.begin(), triangle.end());
    if (largest >= mesh.vertices.size()) {
      return refuse(fmt::format("the mesh of {} has a triangle with vertex {} of {}",
                                name,
                                largest,
                                mesh.vertices.size()));
    }
  }
  return {};
}

Result<void> check_view(ImageView<const Rgb8> color, const OverlayView& view) {
  MOR_CHECK(check_size(color, view.color_camera));
  MOR_CHECK(check_share("opacity", view.opacity));
  MOR_CHECK(check_opacities(view.structure_opacity));
  MOR_CHECK(check_slice(view.slice));
  MOR_CHECK(check_volume_view(view.volume));
  if (view.measured) MOR_CHECK(check_measured(*view.measured));
  MOR_CHECK(check_hole(view.hole));
  if (view.color_from_ct) MOR_CHECK(check_pose(*view.color_from_ct));
  if (view.color_from_ghost) MOR_CHECK(check_pose(*view.color_from_ghost));
  return {};
}

Result<void> check_free_view(const FreeView& view) {
  MOR_CHECK(view.camera.check());
  MOR_CHECK(check_pose(view.view_from_ct));
  MOR_CHECK(check_opacities(view.structure_opacity));
  if (view.picture) {
    MOR_CHECK(check_size(view.picture->color, view.picture->camera));
    MOR_CHECK(check_pose(view.picture->color_from_ct));
    MOR_CHECK(check_hole(view.picture->hole));
    if (view.picture->measured) MOR_CHECK(check_measured(*view.picture->measured));
  }
  if (view.atlas) MOR_CHECK(check_atlas(*view.atlas));
  return {};
}

}  // namespace mor::internal
