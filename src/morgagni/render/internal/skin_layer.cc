// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/skin_layer.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "morgagni/render/internal/composition.h"
#include "morgagni/render/internal/structure_layers.h"

namespace mor::internal {
namespace {

constexpr const char* kSkinFragmentText =
#include "embedded/skin.frag.glsl.inc"
    ;

constexpr const char* kBlackFragmentText =
#include "embedded/black.frag.glsl.inc"
    ;

/// As in skin.frag.glsl.
constexpr GLint kNoSource = 0;
constexpr GLint kPictureSource = 1;
constexpr GLint kAtlasSource = 2;
constexpr GLint kColorsUnit = 0;
constexpr GLint kSeenUnit = 1;

const Eigen::Vector3f kNoColor = Eigen::Vector3f::Zero();

/// A mesh whose vertices each have one place in the atlas: those on a seam are there twice.
struct Unwrapped {
  TriangleMesh mesh;
  std::vector<Eigen::Vector2f> places;  ///< 0..1.
};

Unwrapped unwrap(const AtlasSurface& surface) {
  Unwrapped result;
  const Eigen::Array2f size(static_cast<float>(surface.width_px),
                            static_cast<float>(surface.height_px));
  // The copies of each vertex made so far.
  std::vector<std::vector<std::uint32_t>> copies(surface.mesh.vertices.size());
  for (std::size_t i = 0; i < surface.mesh.triangles.size(); ++i) {
    Triangle& corners = result.mesh.triangles.emplace_back();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = surface.mesh.triangles[i][corner];
      const Eigen::Vector2f place = (surface.corners_px[i][corner].array() + 0.5F) / size;
      auto& of_vertex = copies[vertex];
      const auto found = std::find_if(of_vertex.begin(), of_vertex.end(), [&](std::uint32_t copy) {
        return result.places[copy] == place;
      });
      if (found != of_vertex.end()) {
        corners[corner] = *found;
        continue;
      }
      corners[corner] = static_cast<std::uint32_t>(result.places.size());
      of_vertex.push_back(corners[corner]);
      result.places.push_back(place);
      result.mesh.vertices.push_back(surface.mesh.vertices[vertex]);
      result.mesh.normals.push_back(surface.mesh.normals[vertex]);
    }
  }
  return result;
}

}  // namespace

SkinLayer::SkinLayer(LayerPass pass, LayerPass black_pass)
    : pass_(std::move(pass)), black_pass_(std::move(black_pass)) {}

Result<SkinLayer> SkinLayer::create(const GlContext& context, const TriangleMesh& skin) {
  MOR_TRY(LayerPass pass, LayerPass::create(kSkinFragmentText));
  MOR_TRY(LayerPass black_pass, LayerPass::create(kBlackFragmentText));
  SkinLayer layer(std::move(pass), std::move(black_pass));
  if (skin.empty()) return layer;
  layer.mesh_ = fitting(skin, skin.triangles.size(), context.is_software());
  layer.skin_.emplace("skin", layer.mesh_, kNoColor);
  return layer;
}

Result<Layer> SkinLayer::draw(const FreeView& view, ImageView<const Rgba8> colors) {
  if (view.atlas) set_atlas(*view.atlas);
  const auto& surface = view.atlas ? unwrapped_ : skin_;
  const PixelBox whole{0, 0, view.camera.width_px, view.camera.height_px};
  if (!surface) return Layer{};
  const PixelBox box = seen_box(view.camera, view.view_from_ct, surface->bounds(), whole);
  if (box.empty()) return Layer{};
  const auto uniforms = camera_uniforms(view.camera, view.view_from_ct, surface->bounds(), box);
  if (!uniforms) return Layer{};

  GLint source = kNoSource;
  pass_.use(*uniforms);
  if (view.atlas) {
    source = kAtlasSource;
    atlas_colors_.bind(GL_TEXTURE0 + kColorsUnit);
  } else if (view.picture) {
    const auto& [width, height] = std::pair(colors.width(), colors.height());
    const auto color = camera_uniforms(
        view.picture->camera, view.picture->color_from_ct, mesh_.bounds(), {0, 0, width, height});
    if (color) {
      source = kPictureSource;
      colors_.upload(colors);
      set_picture(*view.picture, *color, view.picture->color_from_ct * view.view_from_ct.inverse());
    }
  }
  glUniform1i(pass_.uniform("source"), source);
  glUniform1i(pass_.uniform("shows_bare"), view.shows_bare_skin ? 1 : 0);
  glUniform1i(pass_.uniform("colors"), kColorsUnit);
  glUniform1i(pass_.uniform("seen_mm"), kSeenUnit);
  MOR_CHECK(target_.begin(box.width, box.height));
  glEnable(GL_DEPTH_TEST);
  surface->draw_side(GlStructure::Side::kOuter);
  black_pass_.use(*uniforms);
  surface->draw_side(GlStructure::Side::kInner);
  return read_layer(target_, box, *uniforms);
}

/// Equations (3) and (4): u = (f_x x/z + p_x) / N, and v alike, pixels counted from the corner.
void SkinLayer::set_picture(const ProjectedPicture& picture,
                            const CameraUniforms& color,
                            const Eigen::Isometry3d& color_from_view) {
  seen_.update(mesh_, picture.camera, picture.color_from_ct);
  seen_mm_.upload(seen_.limit_mm().view());
  colors_.bind(GL_TEXTURE0 + kColorsUnit);
  seen_mm_.bind(GL_TEXTURE0 + kSeenUnit);
  const auto set = [this](const char* name, double x, double y) {
    glUniform2f(pass_.uniform(name), static_cast<float>(x), static_cast<float>(y));
  };
  const PinholeCamera& camera = picture.camera;
  set("picture_focal", camera.focal_x_px / camera.width_px, camera.focal_y_px / camera.height_px);
  set("picture_center",
      (camera.center_x_px + 0.5) / camera.width_px,
      (camera.center_y_px + 0.5) / camera.height_px);
  set("picture_margin", 0.5 / camera.width_px, 0.5 / camera.height_px);
  glUniform1fv(
      pass_.uniform("picture_distortion"), color.distortion.size(), color.distortion.data());
  glUniform1f(pass_.uniform("picture_max_radius_sq"), color.max_radius_sq);
  const PinholeCamera& seen = seen_.camera();
  set("seen_focal_px", seen.focal_x_px, seen.focal_y_px);
  set("seen_center_px", seen.center_x_px, seen.center_y_px);
  const Eigen::Matrix4f to_color = color_from_view.matrix().cast<float>();
  glUniformMatrix4fv(pass_.uniform("color_from_view"), 1, GL_FALSE, to_color.data());
}

void SkinLayer::set_atlas(const AtlasPicture& atlas) {
  if (atlas.surface != atlas_surface_) {
    atlas_surface_ = atlas.surface;
    const Unwrapped unwrapped = unwrap(*atlas.surface);
    unwrapped_.reset();
    if (!unwrapped.mesh.empty()) {
      unwrapped_.emplace("skin", unwrapped.mesh, kNoColor);
      unwrapped_->set_places(unwrapped.places);
    }
  }
  if (atlas.colors != atlas_shown_) {
    atlas_shown_ = atlas.colors;
    atlas_colors_.upload(std::as_const(*atlas.colors).view());
  }
}

}  // namespace mor::internal
