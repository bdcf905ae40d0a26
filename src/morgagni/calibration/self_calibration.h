// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stop_token>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/skin_change.h"
#include "morgagni/calibration/skin_readings.h"
#include "morgagni/camera/depth_correction.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// What is known of a range camera's systematic errors before anything was seen: standard
/// deviations. What the views do not tell stays at the calibration as it is.
struct SensorPrior {
  double offset_mm = 4.0;    ///< Of the depth, the same everywhere in the picture, at 800 mm. > 0.
  double tilt_mm = 3.0;      ///< From the middle to the edge. > 0.
  double shape_mm = 3.0;     ///< Of the rest, smooth over the picture. > 0.
  double shape_reach = 0.5;  ///< How smooth: its reach, in half widths of the picture. > 0.
  /// How far the error does not grow with the distance, as a ratio of the above, where it goes with
  /// it in none of the ways that sensors' errors mostly do. > 0.
  double not_growing_ratio = 0.5;
  double focal_difference_ratio = 0.001;  ///< Of the focal lengths, apart. > 0.
  /// Of a pinhole whose calibration does not say how exactly it is known (RgbdCalibration).
  PinholeSd pinhole{.focal_ratio = 0.006, .center_px = 1.0};
};

struct SelfCalibrationOptions {
  int columns = 13;  ///< Of control points over the depth picture. 3..40.
  int rows = 10;     ///< 3..40.
  SensorPrior prior;
  /// How far the skin may have changed since the CT, smoothly, if the views say that it has. > 0.
  double skin_mm = 2.0;
  double skin_reach_mm = 45.0;  ///< How smoothly. > 0.
  /// Of any pattern of residuals: what field, noise model and skin leave, root mean square. > 0.
  double systematic_mm = 0.03;
  int num_folds = 6;  ///< Of the views in time, each held out once. 3..20.

  [[nodiscard]] Result<void> check() const;
};

/// What the views say of the camera and of the body's skin.
enum class SelfCalibrationVerdict : std::uint8_t {
  kTooFewViews,
  kTooLittleMotion,  ///< Too much of the error would look the same as a pose.
  kOtherBody,        ///< The skin is farther off than a body changes: another one, or a cover.
  kNoError,          ///< Views that were held out are not explained better: leave it as it is.
  kSmall,            ///< There is an error, too small to matter or to be sure of.
  kSkinChanged,      ///< The skin has changed since the CT: following it is proposed.
  kError,            ///< The sensor errs: removing it is proposed, and more where follows_skin.
};

/// "too-few-views", "too-little-motion", "other-body", "no-error", "small", "skin-changed",
/// "error".
[[nodiscard]] std::string_view to_string(SelfCalibrationVerdict verdict);

/// By how much one model explains views that were held out better than another.
struct HeldOutGain {
  double share = 0.0;         ///< Of how far they lie off the skin.
  double significance = 0.0;  ///< Mean gain over its standard error, both over the folds.
  int num_better = 0;         ///< Folds that it explains better.
};

/// How far views that took no part in an estimate lie off the skin, robust root mean square, each
/// with the pose that suits it best.
struct HeldOutFit {
  double as_it_is_mm = 0.0;
  double skin_mm = 0.0;         ///< With the skin free to have changed.
  double sensor_mm = 0.0;       ///< With the sensor corrected.
  double both_mm = 0.0;         ///< With both.
  HeldOutGain sensor;           ///< Of both over the skin alone.
  HeldOutGain skin;             ///< Of the skin over nothing.
  HeldOutGain skin_and_sensor;  ///< Of both over the sensor alone.
  int num_folds = 0;
};

struct SelfCalibration {
  SelfCalibrationVerdict verdict = SelfCalibrationVerdict::kTooFewViews;
  /// The most likely correction, whatever the verdict, and the pinhole that goes with it.
  DepthCorrection correction;
  PinholeCamera depth;
  /// The most likely change of the skin: along with the correction, or where the skin alone has
  /// changed without it.
  SkinChange skin;
  /// Whether registering to the skin as found is part of what is proposed.
  bool follows_skin = false;
  HeldOutFit held_out;
  /// How far the correction moves the body's points, root mean square over skin and views: what the
  /// tracked poses are estimated to be off.
  double shift_mm = 0.0;
  /// What stays unknown of that when it is removed, one standard deviation: errors of a sensor that
  /// look like a pose, of one whose errors are as large as where they can be seen (size_ratio).
  double remaining_mm = 0.0;
  double before_mm = 0.0;      ///< Before any view was seen: what SensorPrior does to a pose.
  double open_share = 0.0;     ///< Of that, so much is not told by these views, whatever its size.
  double focal_x_ratio = 0.0;  ///< Found over stated, less 1.
  double focal_y_ratio = 0.0;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< Found less stated.
  double skin_rms_mm = 0.0;                             ///< Change of the skin, where it was seen.
  double skin_most_mm = 0.0;                            ///< The same, the 99th percentile.
  double skin_shift_mm = 0.0;                           ///< As shift_mm, of following the skin.
  double skin_remaining_mm = 0.0;                       ///< As remaining_mm, of the skin's change.
  bool sees_table = false;  ///< A table under the body told along with it.
  int num_parameters = 0;
  int num_open = 0;  ///< Combinations of them of which the views say less than the prior.
  int num_views = 0;
  /// How large the error is where it is seen, over what was expected of sensors (SensorPrior).
  double size_ratio = 0.0;

  [[nodiscard]] bool corrects_sensor() const { return verdict == SelfCalibrationVerdict::kError; }
  /// Whether anything is proposed.
  [[nodiscard]] bool proposes() const { return corrects_sensor() || follows_skin; }
  /// How far off tracked poses are estimated to be by all that is proposed.
  [[nodiscard]] double now_mm() const;
  /// What stays unknown of the pose when it is done.
  [[nodiscard]] double left_mm() const;
};

/// Separates a camera's systematic error from pose errors and from a changed skin: what is fixed in
/// the picture, what is free in each view, and what is fixed in the CT (docs/self-calibration.md).
///
/// @param skin  The case's, with normals. @param calibration  The views were read with its `depth`;
/// `depth_sd` counts where it is said.
/// @param views  In the order of time. From 20 on something is said.
/// @errors kInvalidArgument: bad options or camera, a value that is not finite; kCancelled: `stop`
/// was requested.
/// @threads Reentrant; one thread. @cost Some seconds for 60 views.
[[nodiscard]] Result<SelfCalibration> estimate_self_calibration(
    const TriangleMesh& skin,
    const RgbdCalibration& calibration,
    const std::vector<SensedSkin>& views,
    const SelfCalibrationOptions& options = {},
    std::stop_token stop = {});

}  // namespace mor
