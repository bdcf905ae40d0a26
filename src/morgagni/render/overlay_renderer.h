// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"
#include "morgagni/render/overlay_view.h"

namespace mor {

/// Something inside the body, as it is drawn. Frame ct.
struct RenderedStructure {
  std::string name;
  TriangleMesh mesh;  ///< With normals.
  Eigen::Vector3f color = {0.93F, 0.89F, 0.78F};
};

/// What the renderer draws of one body. Frame ct.
struct RenderScene {
  std::vector<RenderedStructure> structures;
  TriangleMesh skin;  ///< Where the hole can be opened, what hands are in front of, and the ghost.
  std::shared_ptr<const Volume> volume =
      {};  ///< Beside the body kOutsideHu. None: no slices, no volume rendering.
};

/// Who casts the volume's rays.
enum class VolumeCaster : std::uint8_t {
  kAutomatic,  ///< A GPU; where there is none, or its textures are too small, the CPU.
  kCpu,
  kOpenGl,  ///< The GL device, whatever it is: Mesa's software renderer is slower than kCpu.
};

struct RendererOptions {
  VolumeCaster volume_caster = VolumeCaster::kAutomatic;
};

/// Draws the live picture: the colour frame with the inside of the body in its true place.
///
/// Off-screen OpenGL 3.3 core on EGL: the first GPU that answers, else Mesa's software renderer.
/// @threads The thread that creates it owns the GL context and is the only one to call it.
class OverlayRenderer {
 public:
  /// @errors kDevice: no EGL, no OpenGL 3.3: says what was tried and which package has it.
  /// kInvalidArgument: a broken mesh or volume.
  [[nodiscard]] static Result<std::unique_ptr<OverlayRenderer>> create(
      const RenderScene& scene, const RendererOptions& options = {});
  virtual ~OverlayRenderer() = default;

  /// @return Valid until the next call. Size of `color`.
  /// @errors kInvalidArgument: `color` and `view.color_camera` differ in size, or a value is
  /// outside its range. kDevice: the GL context is lost.
  [[nodiscard]] virtual Result<ImageView<const Rgba8>> render(ImageView<const Rgb8> color,
                                                              const OverlayView& view) = 0;

  /// The device that draws, as OpenGL names it.
  [[nodiscard]] virtual std::string device() const = 0;
};

}  // namespace mor
