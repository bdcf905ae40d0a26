// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/render/internal/gl_objects.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/ray_bundle.h"
#include "morgagni/render/internal/ray_caster.h"

namespace mor::internal {

/// Casts a RayCaster's rays on the GL device, a fragment a ray. The context is current wherever
/// this is used.
class GlRayCaster {
 public:
  /// @errors kDevice: the driver refuses the shaders.
  [[nodiscard]] static Result<GlRayCaster> create();

  /// Whether the device's textures are large enough.
  [[nodiscard]] static bool can_hold(const Volume& volume);

  /// As RayCaster::cast(). @param caster  The same one each time. @errors kDevice: out of memory.
  [[nodiscard]] Result<void> cast(const RayCaster& caster, const RayBundle& bundle, Layer& seen);

 private:
  /// A volume of the caster's pyramid on the device.
  struct Resident {
    GlTexture voxels;
    GlTexture bricks;
    GlTexture table;
    GlTexture table_colors;
    int revision = 0;  ///< Of the caster's view, for which the last three were made.
  };

  explicit GlRayCaster(GlProgram program) : program_(std::move(program)) {}

  Resident& resident(const RayCaster& caster, std::size_t number);
  /// Rays and layers of this picture. @return How many layers a ray meets at most.
  int upload_rays(const RayBundle& bundle, const RayRaster& raster);
  void set_uniforms(const RayCaster::Level& level, const RayBundle& bundle, int num_layers) const;

  GlProgram program_;
  RenderTarget target_;
  GlVertexArray no_vertices_ = make_vertex_array();
  GlTexture rays_;
  GlTexture colors_;
  GlTexture depths_;
  std::vector<Resident> residents_;
};

}  // namespace mor::internal
