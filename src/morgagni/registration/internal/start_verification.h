// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/fixed_surface.h"
#include "morgagni/registration/internal/skin_agreement.h"
#include "morgagni/registration/internal/skin_glance.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_scene.h"

namespace mor::internal {

/// What several pictures say of one pose: counts of pixels add up; of how much skin speaks for it
/// and how firmly it holds it, what the best of them says, as the same skin seen again is no more
/// skin.
[[nodiscard]] SkinAgreement pooled(const std::vector<SkinAgreement>& looks);

/// Holds poses against the picture from the CT's side: is the skin where the camera should see it?
class StartVerifier {
 public:
  StartVerifier(std::shared_ptr<const FixedSurface> fixed, float body_extent_mm);

  /// By some hundreds of points of the skin that face the camera.
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
  std::shared_ptr<const FixedSurface> fixed_;
  SkinGlance glance_;
  double skin_area_mm2_ = 0.0;
};

}  // namespace mor::internal
