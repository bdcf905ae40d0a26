// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/overlay_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/render/internal/camera_uniforms.h"
#include "morgagni/render/internal/composition.h"
#include "morgagni/render/internal/gl_context.h"
#include "morgagni/render/internal/gl_structure.h"
#include "morgagni/render/internal/layer_pass.h"

namespace mor {
namespace {

using internal::CameraUniforms;
using internal::GlContext;
using internal::GlStructure;
using internal::HoleMask;
using internal::Layer;
using internal::LayerPass;
using internal::PixelBox;
using internal::RenderTarget;

constexpr const char* kStructureFragmentText =
#include "embedded/structure.frag.glsl.inc"
    ;
constexpr const char* kBodyFragmentText =
#include "embedded/body.frag.glsl.inc"
    ;
constexpr const char* kGhostFragmentText =
#include "embedded/ghost.frag.glsl.inc"
    ;

const Eigen::Vector3f kGhostColor(0.45F, 0.85F, 1.0F);

/// Triangles drawn a frame by a CPU, all structures together; a GPU gets them all.
constexpr std::size_t kSoftwareTriangles = 20000;
/// Of the skin where only its outline counts.
constexpr std::size_t kBodyTriangles = 4000;
constexpr int kSoftwareSamples =
    0;  ///< Four cost llvmpipe three times the CPU: 33 ms a picture for 12.
constexpr int kGpuSamples = 4;

Result<void> check_mesh(const std::string& name, const TriangleMesh& mesh) {
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    if (!vertex.allFinite()) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("the mesh of {} has a vertex that is not finite", name));
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    const auto largest = *std::max_element(triangle.begin(), triangle.end());
    if (largest >= mesh.vertices.size()) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("the mesh of {} has a triangle with vertex {} of {}",
                                    name,
                                    largest,
                                    mesh.vertices.size()));
    }
  }
  return {};
}

Result<void> check_view(ImageView<const Rgb8> color, const OverlayView& view) {
  MOR_CHECK(view.color_camera.check());
  if (color.width() != view.color_camera.width_px ||
      color.height() != view.color_camera.height_px) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("the colour picture is {} x {} px, its camera {} x {} px",
                                  color.width(),
                                  color.height(),
                                  view.color_camera.width_px,
                                  view.color_camera.height_px));
  }
  if (!(view.opacity >= 0.0F && view.opacity <= 1.0F)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("opacity must be in [0, 1], got {}", view.opacity));
  }
  const Hole& hole = view.hole;
  if (!hole.center.allFinite() || !std::isfinite(hole.radius) || !std::isfinite(hole.rim)) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the hole's centre, radius and rim must be finite numbers");
  }
  const auto is_finite = [](const std::optional<Eigen::Isometry3d>& pose) {
    return !pose || pose->matrix().allFinite();
  };
  if (!is_finite(view.color_from_ct) || !is_finite(view.color_from_ghost)) {
    return make_error(ErrorCode::kInvalidArgument, "a pose to draw at must be finite numbers");
  }
  return {};
}

/// Where the corners of `bounds` are seen, and so all of it: the whole picture where a corner is
/// behind the camera or lines bend.
PixelBox seen_box(const PinholeCamera& camera,
                  const Eigen::Isometry3d& camera_from_ct,
                  const Eigen::AlignedBox3f& bounds) {
  const PixelBox whole{0, 0, camera.width_px, camera.height_px};
  if (camera.has_distortion()) return whole;
  Eigen::AlignedBox2d seen;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3f::CornerType>(i);
    const auto pixel = camera.project(camera_from_ct * bounds.corner(corner).cast<double>());
    if (!pixel) return whole;
    seen.extend(*pixel);
  }
  seen.extend(Eigen::Vector2d(seen.min().array() - 1.0));
  seen.extend(Eigen::Vector2d(seen.max().array() + 2.0));
  const Eigen::AlignedBox2d picture(Eigen::Vector2d::Zero(),
                                    Eigen::Vector2d(camera.width_px, camera.height_px));
  const Eigen::AlignedBox2d shown = seen.intersection(picture);
  if (shown.isEmpty()) return {};
  const Eigen::Vector2i first = shown.min().cast<int>();
  const Eigen::Vector2i end = shown.max().cast<int>();
  return {first.x(), first.y(), end.x() - first.x(), end.y() - first.y()};
}

class GlOverlayRenderer final : public OverlayRenderer {
 public:
  GlOverlayRenderer(std::unique_ptr<GlContext> context,
                    LayerPass body_pass,
                    LayerPass structure_pass,
                    LayerPass ghost_pass)
      : context_(std::move(context)),
        body_pass_(std::move(body_pass)),
        structure_pass_(std::move(structure_pass)),
        ghost_pass_(std::move(ghost_pass)),
        target_(context_->is_software() ? kSoftwareSamples : kGpuSamples) {}

  ~GlOverlayRenderer() override {
    // The members' own destructors speak to this context, whichever one is current by now.
    (void)context_->make_current();
  }

  void add_structures(const std::vector<RenderedStructure>& structures) {
    std::size_t num_triangles = 0;
    for (const auto& structure : structures) num_triangles += structure.mesh.triangles.size();
    for (const auto& structure : structures) {
      if (structure.mesh.empty()) continue;
      structures_.emplace_back(
          structure.name, fitting(structure.mesh, num_triangles), structure.color);
      bounds_.extend(structures_.back().bounds());
    }
  }

  void add_skin(const TriangleMesh& skin) {
    if (skin.empty()) return;
    body_.emplace("body", internal::level_of_detail(skin, kBodyTriangles), kGhostColor);
    ghost_.emplace("skin", fitting(skin, skin.triangles.size()), kGhostColor);
  }

  Result<ImageView<const Rgba8>> render(ImageView<const Rgb8> color,
                                        const OverlayView& view) override {
    MOR_CHECK(check_view(color, view));
    if (!context_->make_current()) return context_lost();
    if (picture_.width() != color.width() || picture_.height() != color.height()) {
      picture_ = Image<Rgba8>(color.width(), color.height());
    }
    internal::copy_background(color, picture_.view());
    if (view.color_from_ct) MOR_CHECK(open_hole(view));
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

  /// As many triangles of the mesh as its share of `num_triangles` gives it on this device.
  [[nodiscard]] TriangleMesh fitting(const TriangleMesh& mesh, std::size_t num_triangles) const {
    std::size_t max_triangles = mesh.triangles.size();
    if (context_->is_software() && num_triangles > kSoftwareTriangles) {
      max_triangles = max_triangles * kSoftwareTriangles / num_triangles;
    }
    return internal::level_of_detail(mesh, max_triangles);
  }

  [[nodiscard]] std::vector<const GlStructure*> shown_structures(
      const std::set<std::string>& hidden) const {
    std::vector<const GlStructure*> shown;
    for (const GlStructure& structure : structures_) {
      if (!hidden.contains(structure.name())) shown.push_back(&structure);
    }
    return shown;
  }

  Result<void> open_hole(const OverlayView& view) {
    mask_.update(view.hole, view.opacity, picture_.width(), picture_.height());
    const PixelBox& box = mask_.box();
    const std::vector<const GlStructure*> shown = shown_structures(view.hidden);
    if (box.empty() || shown.empty()) return {};
    const auto uniforms =
        internal::camera_uniforms(view.color_camera, *view.color_from_ct, bounds_, box);
    if (!uniforms) return {};
    MOR_CHECK(target_.begin(box.width, box.height));
    mark_body(*uniforms);
    glEnable(GL_DEPTH_TEST);
    structure_pass_.draw(shown, *uniforms);
    read_layer(box);
    if (!target_.has_many_samples()) internal::smooth_outline(layer_);
    internal::compose_hole(mask_, layer_, picture_.view());
    return {};
  }

  /// The hole opens the body, not the table beside it: marks where the body is, all of it where its
  /// skin is unknown.
  void mark_body(const CameraUniforms& uniforms) const {
    if (!body_) {
      glClearColor(0.0F, 0.0F, 0.0F, internal::kBodyAlpha / 255.0F);
      glClear(GL_COLOR_BUFFER_BIT);
      return;
    }
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_DEPTH_CLAMP);  // The planes fit the structures, the skin lies around them.
    const GlStructure* const body = &*body_;
    body_pass_.draw({&body, 1}, uniforms);
    glDisable(GL_DEPTH_CLAMP);
  }

  void read_layer(const PixelBox& box) {
    layer_.box = box;
    layer_.pixels.resize(static_cast<std::size_t>(box.width) * box.height);
    target_.read(box.width, box.height, layer_.pixels.data());
  }

  Result<void> draw_ghost(const OverlayView& view) {
    const Eigen::AlignedBox3f& bounds = ghost_->bounds();
    const PixelBox box = seen_box(view.color_camera, *view.color_from_ghost, bounds);
    if (box.empty()) return {};
    const auto uniforms =
        internal::camera_uniforms(view.color_camera, *view.color_from_ghost, bounds, box);
    if (!uniforms) return {};
    const GlStructure* const ghost = &*ghost_;
    MOR_CHECK(target_.begin(box.width, box.height));
    glEnable(GL_DEPTH_TEST);
    ghost_pass_.draw({&ghost, 1}, *uniforms);
    read_layer(box);
    internal::compose_over(layer_, picture_.view());
    return {};
  }

  std::unique_ptr<GlContext> context_;  // First, so that it outlives the others.
  LayerPass body_pass_;
  LayerPass structure_pass_;
  LayerPass ghost_pass_;
  RenderTarget target_;
  std::vector<GlStructure> structures_;
  std::optional<GlStructure> body_;   ///< The skin's outline. None without a skin.
  std::optional<GlStructure> ghost_;  ///< None without a skin.
  Eigen::AlignedBox3f bounds_;        ///< Of the structures, frame ct.
  HoleMask mask_;
  Layer layer_;
  Image<Rgba8> picture_;
};

}  // namespace

Result<std::unique_ptr<OverlayRenderer>> OverlayRenderer::create(
    const std::vector<RenderedStructure>& structures, const TriangleMesh& skin) {
  for (const auto& structure : structures) {
    MOR_CHECK(check_mesh(structure.name, structure.mesh));
  }
  MOR_CHECK(check_mesh("the skin", skin));
  MOR_TRY(auto context, GlContext::create());
  MOR_TRY(LayerPass body_pass, LayerPass::create(kBodyFragmentText));
  MOR_TRY(LayerPass structure_pass, LayerPass::create(kStructureFragmentText));
  MOR_TRY(LayerPass ghost_pass, LayerPass::create(kGhostFragmentText));
  auto renderer = std::make_unique<GlOverlayRenderer>(
      std::move(context), std::move(body_pass), std::move(structure_pass), std::move(ghost_pass));
  renderer->add_structures(structures);
  renderer->add_skin(skin);
  return renderer;
}

}  // namespace mor
