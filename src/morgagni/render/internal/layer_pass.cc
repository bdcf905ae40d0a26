// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/layer_pass.h"

#include <utility>

namespace mor::internal {
namespace {

constexpr const char* kSurfaceVertexText =
#include "embedded/surface.vert.glsl.inc"
    ;

}  // namespace

LayerPass::LayerPass(GlProgram program)
    : program_(std::move(program)),
      camera_from_ct_(glGetUniformLocation(program_.get(), "camera_from_ct")),
      focal_ndc_(glGetUniformLocation(program_.get(), "focal_ndc")),
      center_ndc_(glGetUniformLocation(program_.get(), "center_ndc")),
      distortion_(glGetUniformLocation(program_.get(), "distortion")),
      max_radius_sq_(glGetUniformLocation(program_.get(), "max_radius_sq")),
      depth_clip_(glGetUniformLocation(program_.get(), "depth_clip")),
      depth_range_mm_(glGetUniformLocation(program_.get(), "depth_range_mm")),
      cut_plane_(glGetUniformLocation(program_.get(), "cut_plane")),
      color_(glGetUniformLocation(program_.get(), "color")),
      opacity_(glGetUniformLocation(program_.get(), "opacity")) {}

Result<LayerPass> LayerPass::create(const char* fragment_text) {
  MOR_TRY(GlProgram program, make_program(kSurfaceVertexText, fragment_text));
  return LayerPass(std::move(program));
}

GLint LayerPass::uniform(const char* name) const {
  return glGetUniformLocation(program_.get(), name);
}

void LayerPass::use(const CameraUniforms& uniforms) const {
  glUseProgram(program_.get());
  glUniformMatrix4fv(camera_from_ct_, 1, GL_FALSE, uniforms.camera_from_ct.data());
  glUniform2fv(focal_ndc_, 1, uniforms.focal_ndc.data());
  glUniform2fv(center_ndc_, 1, uniforms.center_ndc.data());
  glUniform1fv(distortion_, uniforms.distortion.size(), uniforms.distortion.data());
  glUniform1f(max_radius_sq_, uniforms.max_radius_sq);
  glUniform2fv(depth_clip_, 1, uniforms.depth_clip.data());
  glUniform2fv(depth_range_mm_, 1, uniforms.depth_range_mm.data());
  glUniform4fv(cut_plane_, 1, uniforms.cut_plane.data());
  glFrontFace(GL_CW);  // Row 0 is the top row, which mirrors what OpenGL calls counter-clockwise.
}

void LayerPass::draw(std::span<const GlStructure* const> structures,
                     const CameraUniforms& uniforms,
                     float opacity) const {
  use(uniforms);
  glUniform1f(opacity_, opacity);
  for (const GlStructure* structure : structures) {
    glUniform3fv(color_, 1, structure->color().data());
    structure->draw(glIsEnabled(GL_CLIP_DISTANCE0) == GL_TRUE);
  }
}

}  // namespace mor::internal
