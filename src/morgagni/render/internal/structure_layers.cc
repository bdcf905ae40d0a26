// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/structure_layers.h"

#include <algorithm>
#include <utility>

#include "morgagni/render/internal/camera_uniforms.h"
#include "morgagni/render/internal/composition.h"

namespace mor::internal {
namespace {

constexpr const char* kStructureFragmentText =
#include "embedded/structure.frag.glsl.inc"
    ;

/// Triangles drawn a frame by a CPU, all structures together; a GPU gets them all.
constexpr std::size_t kSoftwareTriangles = 40000;
/// Of each structure, however many there are beside it: a splinter must not vanish.
constexpr std::size_t kLeastTriangles = 400;
/// From here on nothing shines through.
constexpr float kOpaque = 0.995F;

float opacity_of(const GlStructure& structure, const StructureLayers::Request& request) {
  const auto found = request.opacities.find(structure.name());
  return found == request.opacities.end() ? 1.0F : found->second;
}

}  // namespace

PixelBox seen_box(const PinholeCamera& camera,
                  const Eigen::Isometry3d& camera_from_ct,
                  const Eigen::AlignedBox3f& bounds,
                  const PixelBox& within) {
  if (camera.has_distortion()) return within;
  Eigen::AlignedBox2d seen;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3f::CornerType>(i);
    const auto pixel = camera.project(camera_from_ct * bounds.corner(corner).cast<double>());
    if (!pixel) return within;
    seen.extend(*pixel);
  }
  seen.extend(Eigen::Vector2d(seen.min().array() - 1.0));
  seen.extend(Eigen::Vector2d(seen.max().array() + 2.0));
  const Eigen::AlignedBox2d picture(
      Eigen::Vector2d(within.left, within.top),
      Eigen::Vector2d(within.left + within.width, within.top + within.height));
  const Eigen::AlignedBox2d shown = seen.intersection(picture);
  if (shown.isEmpty()) return {};
  const Eigen::Vector2i first = shown.min().cast<int>();
  const Eigen::Vector2i end = shown.max().cast<int>();
  return {first.x(), first.y(), end.x() - first.x(), end.y() - first.y()};
}

Layer read_layer(RenderTarget& target, const PixelBox& box, const CameraUniforms& uniforms) {
  Layer layer;
  layer.clear(box);
  target.read(box.width, box.height, layer.pixels.data(), layer.depth_mm.data());
  const auto [per_z, offset] = uniforms.depth_clip;
  for (float& depth : layer.depth_mm) {
    depth = depth >= 1.0F ? kNoDepth : offset / (2.0F * depth - 1.0F - per_z);
  }
  smooth_outline(layer);
  return layer;
}

TriangleMesh fitting(const TriangleMesh& mesh, std::size_t num_triangles, bool is_software) {
  std::size_t max_triangles = mesh.triangles.size();
  if (is_software && num_triangles > kSoftwareTriangles) {
    max_triangles =
        std::min(max_triangles,
                 std::max(max_triangles * kSoftwareTriangles / num_triangles, kLeastTriangles));
  }
  return level_of_detail(mesh, max_triangles);
}

Result<StructureLayers> StructureLayers::create(const GlContext& context) {
  MOR_TRY(LayerPass pass, LayerPass::create(kStructureFragmentText));
  return StructureLayers(std::move(pass), context.is_software());
}

void StructureLayers::add(const std::vector<RenderedStructure>& structures) {
  std::size_t num_triangles = 0;
  for (const auto& structure : structures) num_triangles += structure.mesh.triangles.size();
  for (const auto& structure : structures) {
    if (structure.mesh.empty()) continue;
    structures_.emplace_back(
        structure.name, fitting(structure.mesh, num_triangles, is_software_), structure.color);
    bounds_.extend(structures_.back().bounds());
  }
}

Result<void> StructureLayers::draw(const Request& request, std::vector<Layer>& layers) {
  std::vector<const GlStructure*> opaque;
  std::vector<std::pair<const GlStructure*, float>> transparent;
  for (const GlStructure& structure : structures_) {
    const float opacity = opacity_of(structure, request);
    if (opacity >= kOpaque) {
      opaque.push_back(&structure);
    } else if (opacity > 0.0F) {
      transparent.emplace_back(&structure, opacity);
    }
  }
  const auto append = [&](std::span<const GlStructure* const> shown,
                          float opacity) -> Result<void> {
    MOR_TRY(Layer layer, draw_layer(request, shown, opacity));
    if (!layer.box.empty()) layers.push_back(std::move(layer));
    return {};
  };
  if (!opaque.empty()) MOR_CHECK(append(opaque, 1.0F));
  for (const auto& [structure, opacity] : transparent) MOR_CHECK(append({&structure, 1}, opacity));
  return {};
}

Result<std::vector<OutlinedStructure>> StructureLayers::draw_each(const Request& request) {
  std::vector<OutlinedStructure> result;
  for (const GlStructure& structure : structures_) {
    if (opacity_of(structure, request) <= 0.0F) continue;
    const GlStructure* const shown = &structure;
    MOR_TRY(Layer layer, draw_layer(request, {&shown, 1}, 1.0F));
    if (!layer.box.empty()) result.push_back({std::move(layer), structure.color()});
  }
  return result;
}

Result<Layer> StructureLayers::draw_layer(const Request& request,
                                          std::span<const GlStructure* const> structures,
                                          float opacity) {
  Eigen::AlignedBox3f shown_bounds;
  for (const GlStructure* structure : structures) shown_bounds.extend(structure->bounds());
  const PixelBox seen = seen_box(request.camera, request.camera_from_ct, shown_bounds, request.box);
  if (seen.empty()) return Layer{};
  // The planes lie around all of them, so that a structure's shade does not depend on what else is
  // shown.
  auto uniforms = camera_uniforms(request.camera, request.camera_from_ct, bounds_, seen);
  if (!uniforms) return Layer{};
  MOR_CHECK(target_.begin(seen.width, seen.height));
  glEnable(GL_DEPTH_TEST);
  if (request.cut) {
    const Eigen::Vector4f plane = request.cut->coeffs().cast<float>();
    uniforms->cut_plane = {plane.x(), plane.y(), plane.z(), plane.w()};
    glEnable(GL_CLIP_DISTANCE0);
  }
  pass_.draw(structures, *uniforms, opacity);
  glDisable(GL_CLIP_DISTANCE0);
  return read_layer(target_, seen, *uniforms);
}

}  // namespace mor::internal
