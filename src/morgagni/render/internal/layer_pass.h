// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "morgagni/core/result.h"
#include "morgagni/render/internal/camera_uniforms.h"
#include "morgagni/render/internal/gl_objects.h"
#include "morgagni/render/internal/gl_structure.h"

namespace mor::internal {

/// Draws surfaces with one fragment shader, the nearest one seen at each pixel.
class LayerPass {
 public:
  /// @errors kDevice: the driver refuses the shaders.
  [[nodiscard]] static Result<LayerPass> create(const char* fragment_text);

  /// Into the target that is begun. @param uniforms  Made for the box that the target stands for.
  /// @param opacity  Of the surfaces where they face the viewer; a thin wall that turns away is
  /// denser.
  void draw(std::span<const GlStructure* const> structures,
            const CameraUniforms& uniforms,
            float opacity) const;

  /// The program in use, with this camera: for who sets more uniforms and draws by himself.
  void use(const CameraUniforms& uniforms) const;
  [[nodiscard]] GLint uniform(const char* name) const;

 private:
  explicit LayerPass(GlProgram program);

  GlProgram program_;
  GLint camera_from_ct_;
  GLint focal_ndc_;
  GLint center_ndc_;
  GLint distortion_;
  GLint max_radius_sq_;
  GLint depth_clip_;
  GLint depth_range_mm_;
  GLint cut_plane_;
  GLint color_;
  GLint opacity_;
};

}  // namespace mor::internal
