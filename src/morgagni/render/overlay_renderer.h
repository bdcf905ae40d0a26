// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Something inside the body, as it is drawn. Frame ct.
struct RenderedStructure {
  std::string name;
  TriangleMesh mesh;  ///< With normals.
  Eigen::Vector3f color = {0.93F, 0.89F, 0.78F};
};

/// The circle in which the inside is shown; around it the colour picture stays as it is.
struct Hole {
  Eigen::Vector2f center = {0.5F, 0.5F};  ///< Share of the picture's width and height.
  float radius =
      0.35F;  ///< Share of the picture's height. 0: no hole, nothing is shown. >= 2: everywhere.
  float rim = 0.03F;  ///< Width of the soft edge, share of the picture's height.
};

struct OverlayView {
  PinholeCamera color_camera;  ///< Of the colour picture; with its distortion.
  std::optional<Eigen::Isometry3d> color_from_ct = {};  ///< None: the plain colour picture.
  float opacity = 0.75F;                                ///< Of the structures in the hole, 0..1.
  Hole hole = {};
  std::set<std::string> hidden = {};  ///< Names of the structures that are not drawn.
  std::optional<Eigen::Isometry3d> color_from_ghost =
      {};  ///< Where the CT skin is drawn as a ghost to be met (start by placement).
};

/// Draws the live picture: the colour frame with the inside of the body in its true place.
///
/// Off-screen OpenGL 3.3 core on EGL: the first GPU that answers, else Mesa's software renderer.
/// @threads The thread that creates it owns the GL context and is the only one to call it.
class OverlayRenderer {
 public:
  /// @param skin  For the ghost.
  /// @errors kDevice: no EGL, no OpenGL 3.3: says what was tried and which package has it.
  [[nodiscard]] static Result<std::unique_ptr<OverlayRenderer>> create(
      const std::vector<RenderedStructure>& structures, const TriangleMesh& skin);
  virtual ~OverlayRenderer() = default;

  /// @return Valid until the next call. Size of `color`.
  /// @errors kInvalidArgument: `color` and `view.color_camera` differ in size. kDevice: the GL
  /// context is lost.
  [[nodiscard]] virtual Result<ImageView<const Rgba8>> render(ImageView<const Rgb8> color,
                                                              const OverlayView& view) = 0;

  /// The device that draws, as OpenGL names it.
  [[nodiscard]] virtual std::string device() const = 0;
};

}  // namespace mor
