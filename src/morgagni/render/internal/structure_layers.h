// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "morgagni/render/internal/gl_context.h"
#include "morgagni/render/internal/gl_structure.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/layer_pass.h"
#include "morgagni/render/internal/outlines.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor::internal {

/// The structures inside of the body as layers: all opaque ones in one, each transparent one in one
/// of its own. A structure hides its own far side, so a layer a structure is enough to have every
/// pixel in the right order, whatever the order of drawing.
class StructureLayers {
 public:
  /// The context is current, and outlives this. @errors kDevice: the driver refuses a shader.
  [[nodiscard]] static Result<StructureLayers> create(const GlContext& context);

  void add(const std::vector<RenderedStructure>& structures);

  /// What is drawn.
  struct Request {
    PinholeCamera camera;
    Eigen::Isometry3d camera_from_ct = Eigen::Isometry3d::Identity();
    std::map<std::string, float> opacities;  ///< By name, 0..1; those not named are opaque.
    std::optional<Eigen::Hyperplane<double, 3>>
        cut;       ///< Camera frame: what is on its negative side is cut away.
    PixelBox box;  ///< The part of the picture that is drawn.
  };

  /// Appends the layers of this view to `layers`.
  [[nodiscard]] Result<void> draw(const Request& request, std::vector<Layer>& layers);

  /// Each structure that is shown, by itself and opaque.
  [[nodiscard]] Result<std::vector<OutlinedStructure>> draw_each(const Request& request);

 private:
  StructureLayers(LayerPass pass, bool is_software)
      : pass_(std::move(pass)), is_software_(is_software) {}

  [[nodiscard]] Result<Layer> draw_layer(const Request& request,
                                         std::span<const GlStructure* const> structures,
                                         float opacity);

  LayerPass pass_;
  bool is_software_;
  RenderTarget target_;
  std::vector<GlStructure> structures_;
  Eigen::AlignedBox3f bounds_;  ///< Of all, frame ct.
};

/// The part of `within` in which all of `bounds` is seen: all of it where a corner is behind the
/// camera or lines bend.
[[nodiscard]] PixelBox seen_box(const PinholeCamera& camera,
                                const Eigen::Isometry3d& camera_from_ct,
                                const Eigen::AlignedBox3f& bounds,
                                const PixelBox& within);

/// Reads the target's corner into a layer of that box and softens its outline.
/// @param uniforms  It was drawn with.
[[nodiscard]] Layer read_layer(RenderTarget& target,
                               const PixelBox& box,
                               const CameraUniforms& uniforms);

/// As many triangles of the mesh as its share of `num_triangles` gives it on this device.
[[nodiscard]] TriangleMesh fitting(const TriangleMesh& mesh,
                                   std::size_t num_triangles,
                                   bool is_software);

}  // namespace mor::internal
