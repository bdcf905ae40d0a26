// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/registration/fixed_surface.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// A body and what the simulated camera shows of it: one line of the tables.
struct BoundGroup {
  std::string name;  ///< "head", "torso + clutter", ...
  std::shared_ptr<const FixedSurface> body;
  std::string camera;    ///< As after `simulated:`; seed and speed are set by the run.
  double bias_mm = 0.0;  ///< That the camera has. Shown apart, told to the bound and not told.
};

struct BoundStudyOptions {
  std::uint64_t first_seed = 1000;  ///< 2000 to 2059: what the calibration was fitted on.
  int num_seeds = 10;               ///< Each group. >= 1.
  int num_frames = 20;              ///< Each seed. >= 1.
  BodySurfaceOptions depth = {.far_mm = kHandHeldFarMm};

  [[nodiscard]] Result<void> check() const;
};

/// A point of the CT and how far the pose puts it from where it is.
struct BoundTarget {
  enum class Kind : std::uint8_t { kSeenSkin, kCenter, kAnywhere };
  Kind kind = Kind::kAnywhere;
  Eigen::Vector3d ct_mm = Eigen::Vector3d::Zero();
  double error_mm = 0.0;
};

/// A frame, tracked from a start 5 mm / 2 deg off, and the error at five points: the middle of the
/// skin seen, the body's centre, and three anywhere in the body's box.
struct BoundSample {
  std::size_t group = 0;  ///< Index.
  std::uint64_t seed = 0;
  std::uint64_t frame_id = 0;
  double distance_mm = 0.0;  ///< From the camera to the middle of the skin seen.
  TrackingState state = TrackingState::kWaiting;
  PoseInformation information;
  std::vector<BoundTarget> targets;
};

/// Frames in which the body was not found have no sample; they are counted.
struct BoundRuns {
  std::vector<BoundGroup> groups;
  std::vector<BoundSample> samples;
  std::vector<int> num_frames;     ///< A group.
  std::vector<int> num_not_found;  ///< A group.
};

/// Draws the frames and tracks them. The same options, the same samples.
/// @errors kInvalidArgument: bad options or camera names.
[[nodiscard]] Result<BoundRuns> run_bound_study(const std::vector<BoundGroup>& groups,
                                                const BoundStudyOptions& options,
                                                const Progress& progress);

/// The calibration whose bound is the 95 % quantile of the errors in each group as nearly as can
/// be: minimises the squared logarithms of (95 % quantile of error / bound) over the groups without
/// bias, then scales so that it holds in 95 % of all. Frames with doubts are left out.
[[nodiscard]] BoundCalibration fit_bound_calibration(const BoundRuns& runs);

/// One line of a table.
struct BoundCoverage {
  std::string name;
  int num_frames = 0;
  int num_targets = 0;
  double coverage = 0.0;  ///< Share of targets whose error is within the bound.
  double median_error_mm = 0.0;
  double p95_error_mm = 0.0;
  double median_bound_mm = 0.0;
};

/// Overall (without the groups that have a bias), a group, a distance, a kind of target, and the
/// frames with doubts.
[[nodiscard]] std::vector<BoundCoverage> bound_coverage(const BoundRuns& runs,
                                                        const BoundCalibration& calibration);

/// Reports: Markdown to read, JSON, and every target's bound and error as CSV for plots.
[[nodiscard]] std::string to_markdown(const std::vector<BoundCoverage>& lines);
[[nodiscard]] std::string to_json(const std::vector<BoundCoverage>& lines,
                                  const BoundRuns& runs,
                                  const BoundStudyOptions& options,
                                  const BoundCalibration& calibration);
[[nodiscard]] std::string to_csv(const BoundRuns& runs, const BoundCalibration& calibration);

}  // namespace mor
