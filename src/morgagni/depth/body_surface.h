// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/point_cloud.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Of a camera in a hand: bodies lie up to 1.2 m away, and reach behind their middle.
inline constexpr double kHandHeldFarMm = 1500.0;

struct BodySurfaceOptions {
  double near_mm = 0.0;       ///< d_near: nearer readings are dropped. >= 0.
  double far_mm = 1000.0;     ///< d_far, the paper's: farther readings are dropped. > near_mm.
  double max_edge_mm = 10.0;  ///< d_triangulation: neighbours farther apart are not connected. > 0.
  double down_sampling = 2.0;  ///< Every so many pixels, both ways, fractions allowed. [1, 4].

  /// A point is the mean of the readings around it, as far as they are of one surface, each of
  /// which counts once over all points; a curved surface stays where it is. false: the reading at
  /// its pixel alone, as the paper has it. Without down-sampling there are none to average.
  bool averages = true;

  [[nodiscard]] Result<void> check() const;
};

/// The moving surface: what the camera sees of the body, frame depth, mm.
struct BodySurface {
  PointCloud cloud;                 ///< Normals towards the camera.
  std::vector<Triangle> triangles;  ///< Over `cloud`, counter-clockwise seen from the camera.
};

/// The paper's "preprocessing and automatic depth data segmentation": clip, back-project,
/// triangulate over the 8-neighbourhood without edges longer than max_edge_mm, keep the part grown
/// from the image centre (from the nearest valid pixel where the centre has no reading).
class BodySurfaceExtractor {
 public:
  /// @errors kInvalidArgument: bad camera or options.
  [[nodiscard]] static Result<BodySurfaceExtractor> create(const PinholeCamera& depth_camera,
                                                           const BodySurfaceOptions& options);
  BodySurfaceExtractor(BodySurfaceExtractor&&) noexcept;
  BodySurfaceExtractor& operator=(BodySurfaceExtractor&&) noexcept;
  ~BodySurfaceExtractor();

  /// @param depth_mm  Size of the camera's pictures; 0 = no reading.
  /// @param seed_px  Grow from here instead of from the picture's centre: where a tracked body is
  ///        expected. Outside the picture: from its nearest pixel.
  /// @return An empty surface where nothing is in range: no body in view is not an error.
  /// @errors kInvalidArgument: a size unlike the camera's.
  /// @threads One call at a time: keeps its buffers between frames.
  /// @cost At 640x480 on one thread about 3 ms at a down-sampling of 2, 10 ms at 1
  /// (depth_benchmark).
  [[nodiscard]] Result<BodySurface> extract(ImageView<const std::uint16_t> depth_mm,
                                            std::optional<Eigen::Vector2d> seed_px = std::nullopt);

  /// The same where about is known where the body is: keeps the parts of the picture on which most
  /// of `expected` lie, so that neither a hand before the body nor a lone reading is taken for it,
  /// and an arm across it does not cut half of it off.
  /// @param expected  Places of the body's surface, frame depth, mm; right to some centimetres.
  ///        Where none lies on anything: grows from the picture's centre.
  [[nodiscard]] Result<BodySurface> extract(ImageView<const std::uint16_t> depth_mm,
                                            std::span<const Eigen::Vector3d> expected);

 private:
  struct Impl;
  explicit BodySurfaceExtractor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor
