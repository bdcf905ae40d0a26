// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "morgagni/core/image.h"
#include "morgagni/render/free_view.h"
#include "morgagni/render/internal/gl_context.h"
#include "morgagni/render/internal/gl_structure.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/layer_pass.h"
#include "morgagni/render/internal/seen_depth.h"

namespace mor::internal {

/// The CT skin in colours as a layer: what it has no colour for is not there, its inner side is
/// black.
class SkinLayer {
 public:
  /// The context is current, and outlives this. @errors kDevice: the driver refuses a shader.
  [[nodiscard]] static Result<SkinLayer> create(const GlContext& context, const TriangleMesh& skin);

  /// @param colors  The view's picture, its alpha what is to be painted of it. Of that size.
  [[nodiscard]] Result<Layer> draw(const FreeView& view, ImageView<const Rgba8> colors);

 private:
  SkinLayer(LayerPass pass, LayerPass black_pass);

  void set_picture(const ProjectedPicture& picture,
                   const CameraUniforms& color,
                   const Eigen::Isometry3d& color_from_view);
  void set_atlas(const AtlasPicture& atlas);

  LayerPass pass_;
  LayerPass black_pass_;  ///< Of its inner side.
  RenderTarget target_;
  std::optional<GlStructure> skin_;  ///< None: there is no skin.
  TriangleMesh mesh_;                ///< The same, for what the camera sees of it.
  SeenDepth seen_;
  GlPicture colors_;
  GlPicture seen_mm_;
  std::shared_ptr<const AtlasSurface> atlas_surface_;  ///< Whose is
  std::optional<GlStructure> unwrapped_;               ///< this.
  std::shared_ptr<const Image<Rgba8>> atlas_shown_;    ///< Whose is
  GlPicture atlas_colors_;                             ///< this.
};

}  // namespace mor::internal
