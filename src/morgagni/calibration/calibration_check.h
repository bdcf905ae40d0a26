// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "morgagni/calibration/rig_calibration.h"

namespace mor {

/// How good a calibration is today, from a few views of the board.
struct CalibrationCheck {
  int num_views = 0;
  double reprojection_px = 0.0;  ///< Colour camera, root mean square.
  double reprojection_mm_at_1m = 0.0;
  int num_depth_views = 0;          ///< With depth of the board, for the figures below.
  double distance_mm = 0.0;         ///< Of the boards, median.
  double size_error_mm = 0.0;       ///< Root mean square error of the board's sides in space, ...
  double size_error_percent = 0.0;  ///< ... and of their length, mean, with its sign.
  double depth_error_mm = 0.0;      ///< Depth of the board's middle less its place by colour, mean.
  double depth_error_rms_mm = 0.0;  ///< Of blocks of readings on the board, from its place.
  double flatness_mm = 0.0;         ///< Of the same, from the plane through them.

  /// "good", "usable" or "calibrate again", and why.
  [[nodiscard]] std::string verdict() const;
  /// For people, in the order they are read.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> figures() const;
};

/// Holds a calibration against views of a board. Readings are corrected as it says.
/// @errors kInvalidArgument: no view shows the board.
[[nodiscard]] Result<CalibrationCheck> check_calibration(const CalibrationBoard& board,
                                                         const std::vector<RigView>& views,
                                                         const RgbdCalibration& calibration);

}  // namespace mor
