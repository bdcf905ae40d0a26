// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/overlay_renderer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/render/internal/camera_uniforms.h"
#include "morgagni/render/internal/composition.h"
#include "morgagni/render/internal/gl_context.h"
#include "morgagni/render/internal/gl_ray_caster.h"
#include "morgagni/render/internal/hole_wall.h"
#include "morgagni/render/internal/occluders.h"
#include "morgagni/render/internal/outlines.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/ray_caster.h"
#include "morgagni/render/internal/slice_layer.h"
#include "morgagni/render/internal/structure_layers.h"
#include "morgagni/render/internal/view_checks.h"
#include "morgagni/render/internal/view_grid.h"

namespace mor {
namespace {

using internal::GlContext;
using internal::GlStructure;
using internal::HoleMask;
using internal::Layer;
using internal::LayerPass;
using internal::Occluders;
using internal::PictureRays;
using internal::PixelBox;
using internal::RayCaster;
using internal::RenderTarget;
using internal::StructureLayers;
using internal::ViewGrid;

constexpr const char* kGhostFragmentText =
#include "embedded/ghost.frag.glsl.inc"
    ;

const Eigen::Vector3f kGhostColor(0.45F, 0.85F, 1.0F);

/// Of the skin that is compared with measured depth: off by less than the camera's noise.
constexpr std::size_t kBodyTriangles = 10000;
/// The skin's outer side is as thin as lung: the lungs are looked for below it.
constexpr float kChestWallMm = 10.0F;
/// Into the volume, in a live picture; the rest is interpolated. Where there is fog, a ray goes
/// through all of it.
constexpr int kLiveRays = 130000;
constexpr int kLiveFogRays = 80000;

int most_rays(VolumePreset preset) {
  const bool is_fog = preset == VolumePreset::kLung || preset == VolumePreset::kSoftTissue;
  return is_fog ? kLiveFogRays : kLiveRays;
}

class GlOverlayRenderer final : public OverlayRenderer {
 public:
  GlOverlayRenderer(std::unique_ptr<GlContext> context,
                    StructureLayers structures,
                    LayerPass ghost_pass)
      : context_(std::move(context)),
        structures_(std::move(structures)),
        ghost_pass_(std::move(ghost_pass)) {}

  ~GlOverlayRenderer() override {
    // The members' own destructors speak to this context, whichever one is current by now.
    (void)context_->make_current();
  }

  void add(const RenderScene& scene) {
    structures_.add(scene.structures);
    volume_ = scene.volume;
    if (volume_) ray_caster_.emplace(volume_);
    const TriangleMesh& skin = scene.skin;
    if (skin.empty()) return;
    body_ = internal::level_of_detail(skin, kBodyTriangles);
    ghost_.emplace("skin",
                   internal::fitting(skin, skin.triangles.size(), context_->is_software()),
                   kGhostColor);
  }

  Result<void> choose_caster(VolumeCaster wanted) {
    if (!volume_ || wanted == VolumeCaster::kCpu) return {};
    if (wanted == VolumeCaster::kAutomatic &&
        (context_->is_software() || !internal::GlRayCaster::can_hold(*volume_))) {
      return {};
    }
    MOR_TRY(gl_ray_caster_, internal::GlRayCaster::create());
    return {};
  }

  Result<ImageView<const Rgba8>> render(ImageView<const Rgb8> color,
                                        const OverlayView& view) override {
    MOR_CHECK(internal::check_view(color, view));
    if (!context_->make_current()) return context_lost();
    if (picture_.width() != color.width() || picture_.height() != color.height()) {
      picture_ = Image<Rgba8>(color.width(), color.height());
    }
    internal::copy_background(color, picture_.view());
    if (view.color_from_ct) MOR_CHECK(open_hole(color, view));
    if (view.color_from_ghost && ghost_) MOR_CHECK(draw_ghost(view));
    if (glGetError() != GL_NO_ERROR) return context_lost();
    return std::as_const(picture_).view();
  }

  std::string device() const override { return context_->device(); }

 private:
  [[nodiscard]] tl::unexpected<Error> context_lost() const {
    return make_error(ErrorCode::kDevice,
                      fmt::format("{} lost its OpenGL context or ran out of memory", device()));
  }

  Result<void> open_hole(ImageView<const Rgb8> color, const OverlayView& view) {
    mask_.update(view.hole, view.opacity, picture_.width(), picture_.height());
    const PixelBox& box = mask_.box();
    if (box.empty()) return {};
    rays_.update(view.color_camera);
    grid_.update(view.color_camera, body_, *view.color_from_ct);
    MOR_CHECK(draw_layers(view, box));
    const bool has_volume = ray_caster_ && view.volume.preset != VolumePreset::kNone;
    if (layers_.empty() && !has_volume && !view.has_outlines) return {};
    if (mask_.has_rim()) {
      Layer& wall = layers_.emplace_back();
      wall.clear(box);
      internal::draw_hole_wall(view.hole, picture_.view(), rays_, grid_, wall);
    }
    inside_.clear(box);
    if (has_volume) {
      MOR_CHECK(cast_rays(view));
    } else {
      internal::merge_layers(layers_, inside_);
    }
    const PixelBox touched = view.has_outlines ? whole_picture() : box;
    const bool is_something_in_front =
        view.measured && occluders_.update(*view.measured, grid_, color, rays_, touched);
    const Occluders* const in_front = is_something_in_front ? &occluders_ : nullptr;
    internal::compose_hole(mask_, inside_, rays_, grid_, in_front, picture_.view());
    return view.has_outlines ? draw_outlines(view, has_volume, in_front) : Result<void>();
  }

  Result<void> draw_outlines(const OverlayView& view, bool has_volume, const Occluders* in_front) {
    MOR_TRY(const auto structures,
            structures_.draw_each({view.color_camera,
                                   *view.color_from_ct,
                                   view.structure_opacity,
                                   cut_,
                                   whole_picture()}));
    internal::draw_hidden_outlines(structures,
                                   {.mask = &mask_,
                                    .layers = layers_,
                                    .volume = has_volume ? &inside_ : nullptr,
                                    .rays = &rays_,
                                    .grid = &grid_,
                                    .occluders = in_front},
                                   picture_.view());
    return {};
  }

  [[nodiscard]] PixelBox whole_picture() const {
    return {0, 0, picture_.width(), picture_.height()};
  }

  /// All but the volume and the wall.
  Result<void> draw_layers(const OverlayView& view, const PixelBox& box) {
    layers_.clear();
    slice_plane_.reset();
    if (volume_) {
      slice_plane_ = internal::slice_plane(
          view.slice, *volume_, *view.color_from_ct, grid_.skin_at(ray_at(view.hole.center)));
    }
    cut_ = view.slice.cuts ? slice_plane_ : std::nullopt;
    MOR_CHECK(structures_.draw(
        {view.color_camera, *view.color_from_ct, view.structure_opacity, cut_, box}, layers_));
    if (!slice_plane_) return {};
    Layer& slice = layers_.emplace_back();
    slice.clear(box);
    internal::draw_slice(view.slice, *slice_plane_, *volume_, *view.color_from_ct, rays_, slice);
    return {};
  }

  Result<void> cast_rays(const OverlayView& view) {
    ray_caster_->set(view.volume);
    const bool is_lung = view.volume.preset == VolumePreset::kLung;
    if (is_lung) grid_.update_back(body_, *view.color_from_ct);
    const PixelBox& box = mask_.box();
    int stride = 1;
    if (!view.is_still) {
      const int most = most_rays(view.volume.preset);
      while (box.width * box.height > most * stride * stride) ++stride;
    }
    const internal::RayBundle bundle{
        .rays = &rays_,
        .color_from_ct = *view.color_from_ct,
        .layers = layers_,
        .cut = cut_,
        .grid = &grid_,
        .skin_mm = is_lung ? kChestWallMm : 0.0F,
        .stride_px = stride,
        .ray_spacing = static_cast<float>(stride / std::max(view.color_camera.focal_x_px, 1.0)),
        .is_still = view.is_still,
        .is_open = [this, stride](int x, int y) {
          return mask_.reaches(x, y, static_cast<float>(stride));
        }};
    if (gl_ray_caster_) return gl_ray_caster_->cast(*ray_caster_, bundle, inside_);
    ray_caster_->cast(bundle, inside_);
    return {};
  }

  [[nodiscard]] Eigen::Vector2f ray_at(const Eigen::Vector2f& share) const {
    const auto pixel = [](float place, int size) {
      return std::clamp(static_cast<int>(place * static_cast<float>(size)), 0, size - 1);
    };
    return rays_.row(pixel(share.y(), picture_.height()))[pixel(share.x(), picture_.width())];
  }

  Result<void> draw_ghost(const OverlayView& view) {
    const Eigen::AlignedBox3f& bounds = ghost_->bounds();
    const PixelBox box =
        internal::seen_box(view.color_camera, *view.color_from_ghost, bounds, whole_picture());
    if (box.empty()) return {};
    const auto uniforms =
        internal::camera_uniforms(view.color_camera, *view.color_from_ghost, bounds, box);
    if (!uniforms) return {};
    const GlStructure* const ghost = &*ghost_;
    MOR_CHECK(ghost_target_.begin(box.width, box.height));
    glEnable(GL_DEPTH_TEST);
    ghost_pass_.draw({&ghost, 1}, *uniforms, 1.0F);
    internal::compose_over(internal::read_layer(ghost_target_, box, *uniforms), picture_.view());
    return {};
  }

  std::unique_ptr<GlContext> context_;  // First, so that it outlives the others.
  StructureLayers structures_;
  LayerPass ghost_pass_;
  RenderTarget ghost_target_;
  std::optional<GlStructure> ghost_;  ///< None without a skin.
  TriangleMesh body_;                 ///< The skin, simplified. Empty without one.
  HoleMask mask_;
  PictureRays rays_;
  ViewGrid grid_;
  Occluders occluders_;
  std::shared_ptr<const Volume> volume_;
  std::optional<RayCaster> ray_caster_;                 ///< None without a volume.
  std::optional<internal::GlRayCaster> gl_ray_caster_;  ///< None where the CPU casts.
  std::optional<Eigen::Hyperplane<double, 3>> slice_plane_;
  std::optional<Eigen::Hyperplane<double, 3>> cut_;
  std::vector<Layer> layers_;
  Layer inside_;
  Image<Rgba8> picture_;
};

}  // namespace

Result<std::unique_ptr<OverlayRenderer>> OverlayRenderer::create(const RenderScene& scene,
                                                                 const RendererOptions& options) {
  for (const auto& structure : scene.structures) {
    MOR_CHECK(internal::check_mesh(structure.name, structure.mesh));
  }
  MOR_CHECK(internal::check_mesh("the skin", scene.skin));
  if (scene.volume) MOR_CHECK(internal::check_volume(*scene.volume));
  MOR_TRY(auto context, GlContext::create());
  MOR_TRY(auto structure_layers, StructureLayers::create(*context));
  MOR_TRY(LayerPass ghost_pass, LayerPass::create(kGhostFragmentText));
  auto renderer = std::make_unique<GlOverlayRenderer>(
      std::move(context), std::move(structure_layers), std::move(ghost_pass));
  renderer->add(scene);
  MOR_CHECK(renderer->choose_caster(options.volume_caster));
  return renderer;
}

}  // namespace mor
