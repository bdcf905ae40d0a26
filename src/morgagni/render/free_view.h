// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor {

/// The picture of a camera that is laid on the skin (paper, equations (3) and (4)).
struct ProjectedPicture {
  ImageView<const Rgb8> color;
  PinholeCamera camera;  ///< Of `color`; with its distortion.
  Eigen::Isometry3d color_from_ct = Eigen::Isometry3d::Identity();
  /// Hands and instruments in it are not painted on the skin that they hide. None: nothing is in
  /// front of the body.
  std::optional<MeasuredDepth> measured = {};
  Hole hole = {.radius = 0.0F};  ///< In the picture: the skin there is cut away too.
};

/// A surface that has been unwrapped into a picture. Plain values of whoever made it.
struct AtlasSurface {
  TriangleMesh mesh;  ///< With normals. Frame ct.
  /// Of each triangle its corners in the picture, px; (0, 0) is the centre of the first pixel.
  std::vector<std::array<Eigen::Vector2f, 3>> corners_px;
  int width_px = 0;
  int height_px = 0;
};

/// The skin in the colours of an atlas. A new picture is a new pointer.
struct AtlasPicture {
  std::shared_ptr<const AtlasSurface> surface;
  std::shared_ptr<const Image<Rgba8>> colors;  ///< Alpha 0: never seen.
};

/// The body as a virtual camera sees it: the skin in colours, and where it has none the inside.
/// Inner sides of the skin and the background are black.
struct FreeView {
  PinholeCamera camera;  ///< The virtual one, and the size of the result.
  Eigen::Isometry3d view_from_ct = Eigen::Isometry3d::Identity();
  std::optional<ProjectedPicture> picture = {};  ///< The skin's colours; none: it has none,
  std::optional<AtlasPicture> atlas = {};        ///< or those of an atlas, which goes before it.
  /// Skin without colours is shown hatched, so that the body is seen whole; else it is cut away, as
  /// the paper does.
  bool shows_bare_skin = false;
  std::map<std::string, float> structure_opacity =
      {};  ///< By name, 0 (not drawn) to 1; those not named are opaque.
};

/// Looked at until the next picture is drawn.
struct FreePicture {
  ImageView<const Rgba8> picture;
  ImageView<const float> depth_mm;  ///< z in the view's frame of what is seen; 0: background.
};

/// Draws the free view, off-screen as OverlayRenderer.
/// @threads The thread that creates it owns the GL context and is the only one to call it.
class FreeViewRenderer {
 public:
  /// @errors As OverlayRenderer::create.
  [[nodiscard]] static Result<std::unique_ptr<FreeViewRenderer>> create(const RenderScene& scene);
  virtual ~FreeViewRenderer() = default;

  /// @errors kInvalidArgument: a camera or pose that is none, a picture of another size than its
  /// camera's, an atlas whose parts do not belong together. kDevice: the GL context is lost.
  [[nodiscard]] virtual Result<FreePicture> render(const FreeView& view) = 0;
};

}  // namespace mor
