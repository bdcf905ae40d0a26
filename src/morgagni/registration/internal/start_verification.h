// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/fixed_surface.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_scene.h"

namespace mor::internal {

/// What a picture says of the CT's skin at a pose, in parts of the skin that should be seen there.
/// Those from area_share on are of a look, not of a glance.
struct SkinAgreement {
  double num_seen = 0.0;      ///< In view, with a reading.
  double num_agree = 0.0;     ///< Measured where it should be; less the farther from there.
  double num_floating = 0.0;  ///< The camera looks through it: never so at the right pose.
  double num_hidden = 0.0;    ///< Something measured stands before it.
  double area_share = 0.0;    ///< Of all the CT's skin, what is measured well where it should be.
  /// How firmly that skin holds the pose, in the direction it holds least: mean square of what its
  /// distance changes by when the body's ends move by one, 0..1/6. A cylinder holds nothing.
  double firmness = 0.0;
  double num_patches = 0.0;  ///< How much of it, and how evenly it lies there (start_evenness.h).
  double uneven_mm = 0.0;
  double noise_mm = 0.0;     ///< Of a single reading there; standard deviation.
  double noise_share = 1.0;  ///< What is left of it in the mean of all pictures.
};

/// What several pictures say of one pose: counts of pixels add up; of how much skin speaks for it
/// and how firmly it holds it, what the best of them says, as the same skin seen again is no more
/// skin.
[[nodiscard]] SkinAgreement pooled(const std::vector<SkinAgreement>& looks);

/// Holds poses against the picture from the CT's side: is the skin where the camera should see it?
class StartVerifier {
 public:
  StartVerifier(std::shared_ptr<const FixedSurface> fixed, float body_extent_mm);

  /// By some hundreds of points of the skin that face the camera. @cost About 5 us.
  [[nodiscard]] SkinAgreement glance(const StartPicture& picture,
                                     const Eigen::Isometry3d& ct_from_depth,
                                     float tolerance_mm) const;

  /// By the depth that the camera would see, pixel by pixel. @cost About 3 ms.
  /// @param planes  Of the picture: skin that would lie in a large one is not counted, as any flat
  ///        part of a body agrees with a table.
  [[nodiscard]] SkinAgreement look(const StartPicture& picture,
                                   const std::vector<StartPlane>& planes,
                                   const Eigen::Isometry3d& ct_from_depth,
                                   float tolerance_mm) const;

 private:
  struct SkinPoint {
    Eigen::Vector3f point;
    Eigen::Vector3f normal;
  };

  std::shared_ptr<const FixedSurface> fixed_;
  std::vector<SkinPoint> points_;
  double skin_area_mm2_ = 0.0;
};

}  // namespace mor::internal
