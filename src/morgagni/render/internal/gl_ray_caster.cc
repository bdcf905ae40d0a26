// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/gl_ray_caster.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include <tbb/parallel_for.h>

#include "morgagni/render/internal/fragments.h"

namespace mor::internal {
namespace {

constexpr const char* kVertexText =
#include "embedded/rays.vert.glsl.inc"
    ;
constexpr const char* kFragmentText =
#include "embedded/rays.frag.glsl.inc"
    ;

/// The order of the samplers' texture units.
constexpr std::array<const char*, 7> kSamplers = {
    "rays", "colors", "depths", "voxels", "bricks", "table", "table_colors"};
constexpr int kTableWidth = 64;

/// A texture of its own, bound, read without wrapping. @param filter  Between texels.
void renew(GlTexture& texture, GLenum target, GLint filter) {
  GLuint name = 0;
  glGenTextures(1, &name);
  texture = GlTexture(name);
  glBindTexture(target, name);
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
    glTexParameteri(target, axis, GL_CLAMP_TO_EDGE);
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
}

/// Slice by slice, what is beside the body as air.
void upload_voxels(const Volume& volume, GlTexture& texture) {
  renew(texture, GL_TEXTURE_3D, GL_LINEAR);
  const auto [nx, ny, nz] = volume.size;
  glTexImage3D(GL_TEXTURE_3D, 0, GL_R16_SNORM, nx, ny, nz, 0, GL_RED, GL_SHORT, nullptr);
  std::vector<std::int16_t> slice(static_cast<std::size_t>(nx) * ny);
  for (int z = 0; z < nz; ++z) {
    const std::int16_t* const from = volume.hu.data() + volume.index(0, 0, z);
    std::transform(from, from + slice.size(), slice.begin(), [](std::int16_t hu) {
      return std::max<std::int16_t>(hu, TransferTable::kLeastHu);
    });
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, nx, ny, 1, GL_RED, GL_SHORT, slice.data());
  }
}

void upload_table(const TransferTable& table, GlTexture& sums, GlTexture& colors) {
  constexpr int kRows = TransferTable::kNumEntries / kTableWidth;
  std::vector<std::array<float, 3>> entries(TransferTable::kNumEntries);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i] = {table.opacity[i], table.opacity_sum[i], table.moment_sum[i]};
  }
  renew(sums, GL_TEXTURE_2D, GL_NEAREST);
  glTexImage2D(
      GL_TEXTURE_2D, 0, GL_RGB32F, kTableWidth, kRows, 0, GL_RGB, GL_FLOAT, entries.data());
  renew(colors, GL_TEXTURE_2D, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D,
               0,
               GL_RGBA8,
               kTableWidth,
               kRows,
               0,
               GL_RGBA,
               GL_UNSIGNED_BYTE,
               table.colors.data());
}

}  // namespace

Result<GlRayCaster> GlRayCaster::create() {
  MOR_TRY(GlProgram program, make_program(kVertexText, kFragmentText));
  return GlRayCaster(std::move(program));
}

bool GlRayCaster::can_hold(const Volume& volume) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  return *std::max_element(volume.size.begin(), volume.size.end()) <= most;
}

GlRayCaster::Resident& GlRayCaster::resident(const RayCaster& caster, std::size_t number) {
  residents_.resize(caster.levels().size());
  Resident& resident = residents_[number];
  const RayCaster::Level& level = caster.levels()[number];
  if (resident.voxels.get() == 0) upload_voxels(*level.volume, resident.voxels);
  if (resident.revision == caster.revision()) return resident;
  resident.revision = caster.revision();
  upload_table(level.table, resident.table, resident.table_colors);
  renew(resident.bricks, GL_TEXTURE_3D, GL_NEAREST);
  const auto [bx, by, bz] = level.bricks.size();
  glTexImage3D(GL_TEXTURE_3D,
               0,
               GL_R8UI,
               bx,
               by,
               bz,
               0,
               GL_RED_INTEGER,
               GL_UNSIGNED_BYTE,
               level.distances.data());
  return resident;
}

int GlRayCaster::upload_rays(const RayBundle& bundle, const RayRaster& raster) {
  const auto num_rays = static_cast<std::size_t>(raster.width) * raster.height;
  const auto most = std::min<int>(static_cast<int>(bundle.layers.size()), Fragments::kMost);
  std::vector<std::array<float, 4>> rays(num_rays);
  // A texture needs a layer even where nothing is drawn.
  std::vector<Rgba8> colors(num_rays * std::max(most, 1));
  std::vector<float> depths(colors.size(), kNoDepth);
  tbb::parallel_for(0, raster.height, [&](int y) {
    Fragments fragments;
    for (int x = 0; x < raster.width; ++x) {
      const int column = raster.column(x);
      const int row = raster.row(y);
      const std::size_t i = static_cast<std::size_t>(y) * raster.width + x;
      const Eigen::Vector2f& ray = bundle.rays->row(row)[column];
      if (bundle.is_open && !bundle.is_open(column, row)) {
        rays[i] = {ray.x(), ray.y(), kNoDepth, 0.0F};
        continue;
      }
      const RayLimits limits = ray_limits(bundle, ray);
      rays[i] = {ray.x(), ray.y(), limits.first_mm, limits.last_mm};
      fragments.gather(bundle.layers, column, row);
      for (int layer = 0; layer < std::min(fragments.size(), most); ++layer) {
        const std::size_t at = num_rays * static_cast<std::size_t>(layer) + i;
        colors[at] = fragments[layer].color;
        depths[at] = fragments[layer].depth_mm;
      }
    }
  });
  const auto [width, height] = std::pair(raster.width, raster.height);
  renew(rays_, GL_TEXTURE_2D, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, rays.data());
  const auto layered = [&](GlTexture& texture, GLint kept, GLenum format, GLenum type, auto* from) {
    renew(texture, GL_TEXTURE_2D_ARRAY, GL_NEAREST);
    glTexImage3D(
        GL_TEXTURE_2D_ARRAY, 0, kept, width, height, std::max(most, 1), 0, format, type, from);
  };
  layered(colors_, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, colors.data());
  layered(depths_, GL_R32F, GL_RED, GL_FLOAT, depths.data());
  return most;
}

void GlRayCaster::set_uniforms(const RayCaster::Level& level,
                               const RayBundle& bundle,
                               int num_layers) const {
  const RayGeometry geometry = ray_geometry(*level.volume, bundle.color_from_ct);
  const auto place = [this](const char* name) {
    return glGetUniformLocation(program_.get(), name);
  };
  for (std::size_t unit = 0; unit < kSamplers.size(); ++unit) {
    glUniform1i(place(kSamplers[unit]), static_cast<GLint>(unit));
  }
  glUniform1i(place("num_layers"), num_layers);
  glUniform1f(place("surface_entry"), level.table.surface_entry);
  glUniform3iv(place("size"), 1, geometry.size.data());
  glUniform3fv(place("eye"), 1, geometry.eye.data());
  glUniformMatrix3fv(place("voxels_from_ray"), 1, GL_FALSE, geometry.voxels_from_ray.data());
  glUniformMatrix3fv(
      place("color_from_gradient"), 1, GL_FALSE, geometry.color_from_gradient.data());
  glUniform3fv(place("gradient_voxels"), 1, geometry.gradient_voxels.data());
  glUniform2f(place("body_mm"), geometry.nearest_mm, geometry.farthest_mm);
  glUniform1f(place("step_length_mm"), level.step_mm);
}

Result<void> GlRayCaster::cast(const RayCaster& caster, const RayBundle& bundle, Layer& seen) {
  const std::size_t number = caster.level_for(bundle);
  const RayRaster raster(seen.box, bundle.stride_px);
  const Resident& volume = resident(caster, number);
  const int num_layers = upload_rays(bundle, raster);
  MOR_CHECK(target_.begin(raster.width, raster.height));
  glUseProgram(program_.get());
  set_uniforms(caster.levels()[number], bundle, num_layers);
  const std::array<std::pair<GLenum, GLuint>, kSamplers.size()> textures = {
      {{GL_TEXTURE_2D, rays_.get()},
       {GL_TEXTURE_2D_ARRAY, colors_.get()},
       {GL_TEXTURE_2D_ARRAY, depths_.get()},
       {GL_TEXTURE_3D, volume.voxels.get()},
       {GL_TEXTURE_3D, volume.bricks.get()},
       {GL_TEXTURE_2D, volume.table.get()},
       {GL_TEXTURE_2D, volume.table_colors.get()}}};
  for (std::size_t unit = 0; unit < textures.size(); ++unit) {
    glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
    glBindTexture(textures[unit].first, textures[unit].second);
  }
  glActiveTexture(GL_TEXTURE0);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glBindVertexArray(no_vertices_.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<Rgba8> colors(static_cast<std::size_t>(raster.width) * raster.height);
  std::vector<float> depths(colors.size());
  target_.read(raster.width, raster.height, colors.data(), depths.data());
  raster.spread(std::move(colors), seen);
  return {};
}

}  // namespace mor::internal
