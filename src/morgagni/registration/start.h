// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"

namespace mor {

/// The same anatomical point, seen in the CT and by the camera. mm.
struct LandmarkPair {
  Eigen::Vector3d ct;
  Eigen::Vector3d depth;
};

struct LandmarkStart {
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  double fre_mm = 0.0;               ///< Root mean square of `residuals_mm`.
  std::vector<double> residuals_mm;  ///< One a pair, in the order given.
};

/// The start from >= 3 pairs of landmarks (Horn 1987). @errors kInvalidArgument: fewer, collinear,
/// NaN.
[[nodiscard]] Result<LandmarkStart> start_from_landmarks(const std::vector<LandmarkPair>& pairs);

/// The side of the body that faces the camera.
enum class BodySide : std::uint8_t { kAnterior, kPosterior, kLeft, kRight };

/// "anterior", "posterior", "left", "right". None for another word.
[[nodiscard]] std::optional<BodySide> parse_body_side(std::string_view name);

struct PlacementOptions {
  static constexpr double kMinDistanceMm = 100.0;
  static constexpr double kMaxDistanceMm = 3000.0;

  double distance_mm =
      600.0;  ///< From the camera to the nearest point of the body on its axis. 100..3000.
  BodySide side = BodySide::kAnterior;  ///< Turned towards the camera.
  double roll_rad = 0.0;  ///< About the viewing axis; 0: the body's head is up in the picture.

  [[nodiscard]] Result<void> check() const;
};

/// The virtual placement of Glocker et al. (paper's reference [14]): the CT body is put in front of
/// the camera, at its centre; the user moves the camera until picture and ghost fit.
/// @param bounds  Of the CT skin, frame ct.
/// @return ct_from_depth.
[[nodiscard]] Result<Eigen::Isometry3d> place_in_front_of_camera(const Eigen::AlignedBox3f& bounds,
                                                                 const PlacementOptions& options);

}  // namespace mor
