// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/tum_recording.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/evaluation/frame_difficulty.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/evaluation/summary.h"
#include "morgagni/registration/fine_registration.h"

namespace mor {

struct EvaluationOptions {
  RegistrationOptions registration = {};
  BodySurfaceOptions depth = {};
  /// Perturbed starts a frame; 0: each frame starts from the pose before (the first from the
  /// truth).
  int num_starts = 0;
  double start_error_mm = 30.0;   ///< Shift of a perturbed start: uniform up to this. >= 0.
  double start_error_deg = 20.0;  ///< Its rotation about the surface's centroid. [0, 180].
  StartQuality start_quality = StartQuality::kRough;  ///< What a perturbed start is called.
  std::uint64_t seed = 1;
  double success_mm = 10.0;  ///< A run with a smaller TRE is a success. > 0.

  [[nodiscard]] Result<void> check() const;
};

/// One registration.
struct EvaluationRun {
  std::size_t frame = 0;
  std::size_t num_points = 0;  ///< Of the moving surface.
  double tre_mm = 0.0;         ///< Root mean square over the targets, as the paper has it.
  double start_tre_mm = 0.0;   ///< The same of the pose that it started from.
  double rms_distance_mm = 0.0;
  double registration_ms = 0.0;      ///< Of align() alone.
  double registration_cpu_ms = 0.0;  ///< Of the calling thread in it: what a busy machine leaves.
  RegistrationStatus status = RegistrationStatus::kMaxIterations;
};

/// A frame that was registered.
struct EvaluationFrame {
  std::size_t frame = 0;
  FrameDifficulty difficulty;
};

struct EvaluationReport {
  RegistrationMethod method = RegistrationMethod::kField;
  std::string device = "cpu";  ///< Where it ran at the end (FineRegistration::device_name()).
  int num_frames = 0;          ///< With a truth, and so registered.
  int num_starts = 0;
  int num_frames_without_truth = 0;
  double success_mm = 0.0;    ///< A run with a smaller TRE is a success.
  double success_rate = 0.0;  ///< Of the runs, 0..1.
  Summary tre_mm;             ///< Over all runs.
  Summary tre_success_mm;     ///< Over the successes.
  Summary registration_ms;
  Summary registration_cpu_ms;
  Summary depth_ms;  ///< Depth image to body surface, a run.
  double median_points = 0.0;
  std::vector<EvaluationFrame> frames;
  std::vector<EvaluationRun> runs;
};

/// The truth moved by a random rotation about `ct_center` and a random shift: axis and direction
/// even over the sphere, sizes even from 0 to the limits.
[[nodiscard]] Eigen::Isometry3d perturbed_start(const Eigen::Isometry3d& ct_from_depth_truth,
                                                const Eigen::Vector3d& ct_center,
                                                double max_shift_mm,
                                                double max_rotation_rad,
                                                std::mt19937_64& random);

/// Target registration error: root mean square over the targets of how far the found pose puts them
/// from where they are. @param targets  >= 1.
[[nodiscard]] double target_registration_error_mm(const Eigen::Isometry3d& ct_from_depth,
                                                  const Eigen::Isometry3d& ct_from_depth_truth,
                                                  const std::vector<Target>& targets);

/// Registers every frame of a recording that has a truth (nearest time stamp, at most 20 ms off)
/// and measures the error at the targets. The depth picture is segmented from where the start, not
/// the truth, expects the body, as live. Truth and targets are in the frame of `fixed`.
/// @errors kInvalidArgument: bad options, no targets, no frame with a truth, a frame without any
///         surface in range; whatever the recording's reader reports.
[[nodiscard]] Result<EvaluationReport> evaluate_recording(
    const TumRecording& recording,
    const std::shared_ptr<const FixedSurface>& fixed,
    const std::vector<TimedPose>& truth,
    const std::vector<Target>& targets,
    const EvaluationOptions& options,
    const Progress& progress);

/// {"method","device","frames","starts","success_rate","tre_mm":{mean,sd,median,p95,max},
/// "tre_success_mm","registration_ms":{median,p95},"registration_cpu_ms":{median,p95},"points",
/// "difficulty":[{frame,bare_share,least_tre_mm}],"runs":[{frame,tre_mm,start_tre_mm,cpu_ms}]}. An
/// infinite bound is null.
[[nodiscard]] std::string to_json(const EvaluationReport& report);

/// The same as a table to read, with the depth stage's time and the success by bare skin.
[[nodiscard]] std::string to_table(const EvaluationReport& report);

}  // namespace mor
