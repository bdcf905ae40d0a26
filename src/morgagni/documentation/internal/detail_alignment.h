// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/documentation/internal/frame_look.h"

namespace mor::internal {

/// A place of the skin whose brightness, without what is wider than a centimetre, is known.
struct KnownDetail {
  Eigen::Vector3f at_mm;
  Eigen::Vector3f normal;
  float brightness = 0.0F;  ///< Above or below its surroundings.
};

struct DetailAlignment {
  Eigen::Isometry3d color_from_ct = Eigen::Isometry3d::Identity();
  double shift_mm = 0.0;  ///< How far the places moved, in the mean.
};

/// Moves a frame to where its details lie on the known ones: Gauss-Newton over the six degrees of
/// freedom on differences of brightness (Lucas and Kanade, 1981), held to the tracker's pose as
/// strongly as that is sure.
/// @param frame  Is moved to the pose that is returned.
/// @param gain  Brings the frame's brightness to the details'.
/// @param pose_sd_mm  Standard deviation of the pose at the skin it shows. > 0.
/// @return None where there are too few details in common.
[[nodiscard]] std::optional<DetailAlignment> align_details(FrameLook& frame,
                                                           const std::vector<KnownDetail>& details,
                                                           const Eigen::Isometry3d& color_from_ct,
                                                           float gain,
                                                           double pose_sd_mm);

}  // namespace mor::internal
