// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/depth_readings.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// One number of the depth camera's geometry, and whether the views say anything about it.
struct PlaneUnknown {
  std::string name;        ///< "focal length, %", "shift x, mm".
  double value = 0.0;      ///< Change from the design.
  double sd = 0.0;         ///< What is left uncertain.
  double sd_before = 0.0;  ///< As uncertain as the design leaves it.
  /// The views tell it better than the design by half. Else it stays near the design's value.
  [[nodiscard]] bool is_determined() const { return sd < 0.5 * sd_before; }
};

struct PlaneGeometry {
  PinholeCamera depth;
  Eigen::Isometry3d color_from_depth = Eigen::Isometry3d::Identity();
  std::vector<PlaneUnknown> unknowns = {};
  double rms_mm = 0.0;  ///< Of the readings from their planes.
};

/// A board as the colour camera places it, and what the depth camera read of its plane.
struct PlaneView {
  Eigen::Isometry3d color_from_board = Eigen::Isometry3d::Identity();
  std::vector<DepthReading> readings;  ///< `px` and `seen_mm` count.
};

/// A depth camera without an infrared picture sees boards as planes only. From planes in many
/// tilts this finds how it lies to the colour camera, its focal length and centre, and a scale and
/// offset of its depth, all weighed against the design; what planes cannot tell (the lens's
/// distortion at all, the centre and the shifts weakly) stays as designed, and is said.
/// @errors kInvalidArgument: fewer than 6 planes, or all parallel.
[[nodiscard]] Result<PlaneGeometry> find_plane_geometry(const std::vector<PlaneView>& views,
                                                        const RgbdCalibration& by_design);

}  // namespace mor
