// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/free_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/render/internal/composition.h"
#include "morgagni/render/internal/gl_context.h"
#include "morgagni/render/internal/occluders.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/skin_layer.h"
#include "morgagni/render/internal/structure_layers.h"
#include "morgagni/render/internal/view_checks.h"
#include "morgagni/render/internal/view_grid.h"

namespace mor {
namespace {

using internal::GlContext;
using internal::Layer;
using internal::SkinLayer;
using internal::StructureLayers;

/// Of the skin that is compared with measured depth, as in the overlay.
constexpr std::size_t kBodyTriangles = 10000;

constexpr std::uint8_t scaled(unsigned a, unsigned b) {
  return static_cast<std::uint8_t>((a * b + 127U) / 255U);
}

class GlFreeViewRenderer final : public FreeViewRenderer {
 public:
  GlFreeViewRenderer(std::unique_ptr<GlContext> context,
                     StructureLayers structures,
                     SkinLayer skin,
                     TriangleMesh body)
      : context_(std::move(context)),
        structures_(std::move(structures)),
        skin_(std::move(skin)),
        body_(std::move(body)) {}

  ~GlFreeViewRenderer() override {
    // The members' own destructors speak to this context, whichever one is current by now.
    (void)context_->make_current();
  }

  Result<FreePicture> render(const FreeView& view) override {
    MOR_CHECK(internal::check_free_view(view));
    if (!context_->make_current()) return context_lost();
    const auto& [width, height] = std::pair(view.camera.width_px, view.camera.height_px);
    if (view.picture && !view.atlas) cut_out(*view.picture);
    layers_.clear();
    MOR_TRY(Layer skin, skin_.draw(view, std::as_const(colors_).view()));
    if (!skin.box.empty()) layers_.push_back(std::move(skin));
    MOR_CHECK(structures_.draw({.camera = view.camera,
                                .camera_from_ct = view.view_from_ct,
                                .opacities = view.structure_opacity,
                                .cut = std::nullopt,
                                .box = {0, 0, width, height}},
                               layers_));
    if (glGetError() != GL_NO_ERROR) return context_lost();
    merged_.clear({0, 0, width, height});
    internal::merge_layers(layers_, merged_);
    // Over black, premultiplied colours stay as they are.
    for (Rgba8& pixel : merged_.pixels) pixel.a = 255;
    for (float& depth : merged_.depth_mm) {
      if (depth == internal::kNoDepth) depth = 0.0F;
    }
    return FreePicture{{merged_.pixels.data(), width, height},
                       {merged_.depth_mm.data(), width, height}};
  }

 private:
  [[nodiscard]] tl::unexpected<Error> context_lost() const {
    return make_error(
        ErrorCode::kDevice,
        fmt::format("{} lost its OpenGL context or ran out of memory", context_->device()));
  }

  /// The camera's picture, without what is in front of the skin and without the hole.
  void cut_out(const ProjectedPicture& picture) {
    const auto& [width, height] = std::pair(picture.color.width(), picture.color.height());
    if (colors_.width() != width || colors_.height() != height)
      colors_ = Image<Rgba8>(width, height);
    internal::copy_background(picture.color, colors_.view());
    cut_hole(picture.hole);
    if (!picture.measured) return;
    rays_.update(picture.camera);
    grid_.update(picture.camera, body_, picture.color_from_ct);
    if (!occluders_.update(*picture.measured, grid_, picture.color, rays_, {0, 0, width, height})) {
      return;
    }
    for (int y = 0; y < height; ++y) {
      Rgba8* pixels = colors_.view().row(y);
      const std::uint8_t* in_front = occluders_.row(y, 0);
      for (int x = 0; x < width; ++x) pixels[x].a = scaled(pixels[x].a, 255U - in_front[x]);
    }
  }

  void cut_hole(const Hole& hole) {
    mask_.update(hole, 1.0F, colors_.width(), colors_.height());
    const internal::PixelBox& box = mask_.box();
    if (box.empty()) return;
    for (int y = box.top; y < box.top + box.height; ++y) {
      Rgba8* pixels = colors_.view().row(y) + box.left;
      const auto* weights = mask_.row(y);
      for (int x = 0; x < box.width; ++x) {
        pixels[x].a = static_cast<std::uint8_t>(255U - weights[x].structure);
      }
    }
  }

  std::unique_ptr<GlContext> context_;  // First, so that it outlives the others.
  StructureLayers structures_;
  SkinLayer skin_;
  TriangleMesh body_;  ///< The skin, simplified. Empty without one.
  internal::HoleMask mask_;
  internal::PictureRays rays_;
  internal::ViewGrid grid_;
  internal::Occluders occluders_;
  Image<Rgba8> colors_;
  std::vector<Layer> layers_;
  Layer merged_;
};

}  // namespace

Result<std::unique_ptr<FreeViewRenderer>> FreeViewRenderer::create(const RenderScene& scene) {
  for (const auto& structure : scene.structures) {
    MOR_CHECK(internal::check_mesh(structure.name, structure.mesh));
  }
  MOR_CHECK(internal::check_mesh("the skin", scene.skin));
  MOR_TRY(auto context, GlContext::create());
  MOR_TRY(auto structures, StructureLayers::create(*context));
  MOR_TRY(auto skin, SkinLayer::create(*context, scene.skin));
  structures.add(scene.structures);
  TriangleMesh body;
  if (!scene.skin.empty()) body = internal::level_of_detail(scene.skin, kBodyTriangles);
  return std::make_unique<GlFreeViewRenderer>(
      std::move(context), std::move(structures), std::move(skin), std::move(body));
}

}  // namespace mor
