// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/render/internal/camera_uniforms.h"
#include "morgagni/render/internal/gl_objects.h"
#include "morgagni/render/internal/gl_structure.h"
#include "morgagni/render/internal/pixel_box.h"

namespace mor::internal {

/// A part of the picture with what is drawn there, to be laid over the camera's pixels.
struct Layer {
  PixelBox box;
  std::vector<Rgba8> pixels;  ///< Row by row from the top, premultiplied by alpha.

  [[nodiscard]] const Rgba8* row(int y) const {
    return pixels.data() + static_cast<std::size_t>(y - box.top) * box.width;
  }
};

/// Draws surfaces with one fragment shader, the nearest one seen at each pixel.
class LayerPass {
 public:
  /// @errors kDevice: the driver refuses the shaders.
  [[nodiscard]] static Result<LayerPass> create(const char* fragment_text);

  /// Into the target that is begun. @param uniforms  Made for the box that the target stands for.
  void draw(std::span<const GlStructure* const> structures, const CameraUniforms& uniforms) const;

 private:
  explicit LayerPass(GlProgram program);
  void set_camera(const CameraUniforms& uniforms) const;

  GlProgram program_;
  GLint camera_from_ct_;
  GLint focal_ndc_;
  GLint center_ndc_;
  GLint distortion_;
  GLint max_radius_sq_;
  GLint depth_clip_;
  GLint depth_range_mm_;
  GLint color_;
};

}  // namespace mor::internal
