// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/image.h"
#include "morgagni/geometry/depth_raster.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// A place of the skin as a frame shows it.
struct SkinSight {
  Eigen::Vector2f color_px;  ///< In the colour picture.
  Eigen::Vector2f look_px;   ///< In the frame's look.
  float cosine = 0.0F;       ///< Between normal and the way to the camera.
  float distance_mm = 0.0F;  ///< To the camera.
  float px_per_mm = 0.0F;    ///< Of the colour picture, in its coarser direction.
};

/// Which of a frame's pixels show the CT's skin and nothing but it, at a pose.
///
/// It looks from the colour camera, without lens distortion and no finer than the depth picture. A
/// pixel is skin where the CT's skin must be seen, away from its outline and from where it hides
/// itself, where depth readings around lie on it, and where none within the margin stands before
/// it.
class FrameLook {
 public:
  struct Options {
    double clutter_margin_mm = 14.0;
    double depth_tolerance_mm = 8.0;  ///< A reading so far before the skin is no skin.
    float least_cosine = 0.36F;
  };

  /// @pre The pictures have the calibration's sizes.
  FrameLook(const RgbdFrame& frame,
            const TriangleMesh& skin,
            const Eigen::Isometry3d& color_from_ct,
            const Options& options);

  /// A place of the skin that this frame shows; none where it does not.
  [[nodiscard]] std::optional<SkinSight> sight(const Eigen::Vector3f& at_ct,
                                               const Eigen::Vector3f& normal) const;

  /// From now on places are looked for at another pose nearby; what is skin stays.
  void move_to(const Eigen::Isometry3d& color_from_ct) {
    color_from_ct_ = color_from_ct.cast<float>();
  }
  [[nodiscard]] const Eigen::Isometry3f& color_from_ct() const { return color_from_ct_; }

  [[nodiscard]] Eigen::Vector3f color(const SkinSight& sight) const;
  /// The same without details smaller than some 12 mm, and the share of the surroundings that is
  /// skin. Share 0: there is none.
  [[nodiscard]] Eigen::Vector4f soft_color(const SkinSight& sight) const;
  [[nodiscard]] double skin_share() const { return skin_share_; }
  [[nodiscard]] const PinholeCamera& camera() const { return color_camera_; }

 private:
  void compare_depth(const RgbdFrame& frame, const Options& options);
  void soften(const RgbdFrame& frame);

  const RgbdFrame& frame_;
  PinholeCamera color_camera_;
  PinholeCamera look_camera_;  ///< Without distortion.
  double color_scale_ = 1.0;   ///< Colour pixels a pixel of the look.
  Eigen::Isometry3f color_from_ct_;
  Options options_;
  DepthRaster raster_;
  Image<std::uint8_t> is_skin_;
  /// Colours without details, times the share of their surroundings that is skin; and that share.
  /// Half the look's resolution.
  Image<Eigen::Vector4f> soft_;
  double skin_share_ = 0.0;
  double middle_distance_mm_ = 0.0;
};

}  // namespace mor::internal
