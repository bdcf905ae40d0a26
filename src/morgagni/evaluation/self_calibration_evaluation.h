// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "morgagni/calibration/self_calibration.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/evaluation/recorded_bias.h"
#include "morgagni/registration/fixed_surface.h"

namespace mor {

/// A systematic error of depth that the simulated camera does not have itself, smooth, seeded.
enum class AddedBias : std::uint8_t {
  kNone,
  kFixed,   ///< The same at every distance, as time of flight has it.
  kSquare,  ///< Grows with the square of the distance, as a wrong disparity does.
};

/// A body and what the simulated camera shows of it: one line of the table.
struct SelfCalibrationGroup {
  std::string name;
  std::shared_ptr<const FixedSurface> body;
  std::string camera;  ///< As after `simulated:`; seed and speed are set by the run.
  AddedBias added = AddedBias::kNone;
  double added_mm = 0.0;         ///< Root mean square at 800 mm.
  double changed_skin_mm = 0.0;  ///< The body has changed by so much since its CT, smoothly.
  /// How exactly the camera's calibration knows its pinhole: what it says of it is off by that, at
  /// random. None: it does not say how exact it is, and the pinhole is as `camera` has it.
  std::optional<PinholeSd> pinhole_sd = std::nullopt;
  /// A recorded sensor's error, which the simulated camera gets, and the recorded body's change,
  /// which the body before it gets. Null: none.
  std::shared_ptr<const RecordedBias> recorded = nullptr;
  /// The error is measured at these frames of the same sensor, in place of simulated ones.
  std::shared_ptr<const RecordedFrames> held = nullptr;
};

struct SelfCalibrationStudyOptions {
  std::uint64_t first_seed = 1000;  ///< Below 1000: seeds that the method was set on.
  int num_seeds = 10;               ///< >= 1.
  int num_views = 60;               ///< That the estimate sees. 20..500.
  int frames_apart = 30;            ///< From a view to the next. >= 1.
  int num_held = 20;                ///< Frames after them, at which the error is measured. >= 1.
  BodySurfaceOptions depth;
  SelfCalibrationOptions estimate;

  [[nodiscard]] Result<void> check() const;
};

/// Target registration errors of the held frames, each registered anew.
struct HeldErrors {
  std::vector<double> all_mm;     ///< At targets on the skin and inside.
  std::vector<double> inside_mm;  ///< At those inside alone, which a changed skin does not move.
};

/// One seed.
struct SelfCalibrationRun {
  std::size_t group = 0;
  std::uint64_t seed = 0;
  SelfCalibration found;
  HeldErrors before;    ///< As the camera and the CT are.
  HeldErrors sensor;    ///< With the sensor corrected, whatever the verdict.
  HeldErrors followed;  ///< As a user has it who follows the verdict.
  double cpu_s = 0.0;   ///< Of the estimate.
};

/// Draws views and held frames, estimates, and registers the held frames with and without.
/// The same options, the same runs. @errors kInvalidArgument: bad options or camera names.
[[nodiscard]] Result<std::vector<SelfCalibrationRun>> run_self_calibration_study(
    const std::vector<SelfCalibrationGroup>& groups,
    const SelfCalibrationStudyOptions& options,
    const Progress& progress);

/// Target registration errors at a recording's frames, started from the truth.
struct RecordedLimit {
  std::vector<double> as_it_is_mm;
  std::vector<double> without_error_mm;  ///< Of the sensor, as these frames show it by the truth.
  std::vector<double> with_body_mm;      ///< And against the body as it is now.
};

/// How near the best knowledge of the sensor, and of the body, would bring a recording's frames.
/// @errors As the registration's.
[[nodiscard]] Result<RecordedLimit> recorded_limit(const std::shared_ptr<const FixedSurface>& body,
                                                   const RecordedFrames& recorded,
                                                   const RecordedBias& bias,
                                                   const BodySurfaceOptions& depth);

/// Reports: a table to read, and every run as JSON.
[[nodiscard]] std::string to_markdown(const std::vector<SelfCalibrationGroup>& groups,
                                      const std::vector<SelfCalibrationRun>& runs);
[[nodiscard]] std::string to_json(const std::vector<SelfCalibrationGroup>& groups,
                                  const std::vector<SelfCalibrationRun>& runs,
                                  const SelfCalibrationStudyOptions& options);

}  // namespace mor
