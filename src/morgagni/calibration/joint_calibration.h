// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/board.h"
#include "morgagni/calibration/board_finder.h"
#include "morgagni/calibration/depth_fit.h"
#include "morgagni/calibration/depth_readings.h"
#include "morgagni/camera/range_camera.h"

namespace mor {

/// A board at one place, as both cameras saw it and as the depth camera measured it.
struct JointView {
  std::optional<BoardSighting> color;
  std::optional<BoardSighting> infrared;
  std::vector<DepthReading> readings;  ///< `px`, `seen_mm` and `is_beside` count.
  Eigen::Isometry3d depth_from_board = Eigen::Isometry3d::Identity();  ///< Roughly.
};

/// How far the design of the depth camera is believed: standard deviations.
struct DesignTrust {
  double focal_share = 0.02;
  double aspect_share = 0.003;  ///< Of one focal length to the other.
  double center_px = 8.0;
  double radial = 0.1;        ///< k1 and k2.
  double tangential = 0.001;  ///< p1 and p2.
  double turn_rad = 0.026;    ///< Of camera to camera, about each axis.
  double shift_mm = 5.0;
};

struct JointOptions {
  DepthForm form = DepthForm::kDisparity;  ///< Not kAuto.
  DepthFitOptions depth = {};
  /// Where a place of the infrared picture lies in the depth picture, from there.
  Eigen::Vector2d infrared_offset_px = Eigen::Vector2d::Zero();
  /// Where no infrared picture shows the depth camera's lens. None: the design is not asked.
  std::optional<DesignTrust> design_trust = std::nullopt;
};

struct JointCalibration {
  PinholeCamera color;
  PinholeCamera depth;  ///< Of the infrared picture.
  Eigen::Isometry3d color_from_depth = Eigen::Isometry3d::Identity();
  DepthCorrection correction;
  std::vector<Eigen::Isometry3d> depth_from_board;  ///< In the order of the views.
  /// What the board lies on, from its face: so far behind it, and turned about its axes.
  double wall_behind_mm = 0.0;
  Eigen::Vector2d wall_tilt_rad = Eigen::Vector2d::Zero();

  PinholeCamera color_sd;  ///< Standard deviations, in the members of the same name.
  PinholeCamera depth_sd;
  Eigen::Vector3d turn_sd_rad = Eigen::Vector3d::Zero();  ///< Of color_from_depth.
  Eigen::Vector3d shift_sd_mm = Eigen::Vector3d::Zero();
  double color_rms_px = 0.0;  ///< Distances between corners seen and expected.
  double infrared_rms_px = 0.0;
};

/// Both lenses, how the cameras lie to each other, every board's pose and the depth's correction in
/// one least squares: each corner and each reading counts by its own noise, and what one camera
/// knows of a pose serves all. Gauss-Newton from a start nearby, with robust weights.
/// @param start  Lenses and color_from_depth, roughly; the design, where it is trusted.
/// @param views  Each with corners in one picture at least.
/// @cost 0.4 s for 34 views of 54 corners, ten of them on a wall.
[[nodiscard]] JointCalibration calibrate_jointly(const CalibrationBoard& board,
                                                 const std::vector<JointView>& views,
                                                 const RgbdCalibration& start,
                                                 const JointOptions& options);

/// What readings are off from their board's plane, root mean square: as they are, and corrected.
struct ReadingErrors {
  double rms_before_mm = 0.0;
  double rms_after_mm = 0.0;
};

/// @param view  Of those that were calibrated; `readings` need not have been.
[[nodiscard]] ReadingErrors reading_errors(const CalibrationBoard& board,
                                           const JointCalibration& calibration,
                                           std::size_t view,
                                           const std::vector<DepthReading>& readings,
                                           const Eigen::Vector2d& infrared_offset_px);

}  // namespace mor
