// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "morgagni/calibration/board.h"
#include "morgagni/calibration/board_finder.h"
#include "morgagni/calibration/depth_fit.h"
#include "morgagni/calibration/lens_calibration.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// A board that held still, as a range camera saw it.
struct RigView {
  std::string name;
  std::optional<BoardSighting> color;
  std::optional<BoardSighting> infrared;  ///< By the depth camera, in its own picture.
  Image<float> depth_mm;  ///< Mean of several frames is best; 0 = no reading. Empty: none.
};

struct RigOptions {
  LensOptions lens = {};
  DepthFitOptions depth = {};
  bool fits_depth = true;
  /// Where a place of the infrared picture lies in the depth picture, from there. -50..50.
  Eigen::Vector2d infrared_offset_px = Eigen::Vector2d::Zero();
};

struct StereoQuality {
  double rms_px = 0.0;
  Eigen::Vector3d shift_sd_mm = Eigen::Vector3d::Zero();
  double turn_sd_deg = 0.0;
  int num_views = 0;
};

/// One number of a depth camera that was found without infrared pictures.
struct DesignChange {
  std::string name;        ///< "focal length, %", "shift x, mm".
  double value = 0.0;      ///< Change from the design.
  double sd = 0.0;         ///< What is left uncertain.
  double sd_before = 0.0;  ///< As uncertain as the design leaves it.
  /// The views tell it better than the design by half. Else it stays near the design's value.
  [[nodiscard]] bool is_determined() const { return sd < 0.5 * sd_before; }
};

/// What became of a set of views.
struct RigCalibration {
  RgbdCalibration calibration;
  LensCalibration color;
  std::optional<LensCalibration> infrared;  ///< Of the depth camera, with infrared pictures;
  std::optional<StereoQuality> stereo;      ///< then this too;
  std::vector<DesignChange> changes;        ///< without them this.
  std::optional<DepthFit> depth;
  std::vector<std::string> remarks;  ///< What was not done, and why, in whole sentences.

  /// What it is worth, for people, in the order they are read.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> figures() const;
};

/// Calibrates both cameras of a device, how they lie to each other, and the depth's error: each
/// lens alone first, to tell views that do not do, then all together (calibrate_jointly()).
/// @param by_design  Picture sizes, and what stands where the views say nothing.
/// @errors kInvalidArgument: the views do not do; says why and what to add.
/// @cost About 3 s for 25 views.
[[nodiscard]] Result<RigCalibration> calibrate_rig(const CalibrationBoard& board,
                                                   const std::vector<RigView>& views,
                                                   const RgbdCalibration& by_design,
                                                   const RigOptions& options = {});

}  // namespace mor
