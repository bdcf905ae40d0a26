// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/evaluation/study_poses.h"
#include "morgagni/evaluation/summary.h"
#include "morgagni/registration/fine_registration.h"

namespace mor {

/// The studies of Kilgus et al. 2015, section 3, over a simulated camera.
struct StudiesOptions {
  std::uint64_t seed = 1000;  ///< Of markers, poses, noise, clutter and tagging.
  int num_poses = 5;          ///< A table's. The paper's: 5. >= 1.
  int num_many_poses = 40;    ///< Of the studies that the paper's few poses are too few for. >= 1.
  /// Rows of table 3, of the paper's; tables 1 and 2 have the first. Not empty, each in [1, 4].
  std::vector<double> down_samplings = {1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0};
  bool runs_opencl = true;  ///< The paper's methods on OpenCL too.
  TaggingOptions tagging = {};
  double bias_mm = 3.0;              ///< Of the study of a biased sensor, [0, 20].
  double focal_error_percent = 1.0;  ///< Of the same, [-5, 5].
  double success_mm = 10.0;          ///< A smaller error inside the body is a success. > 0.

  [[nodiscard]] Result<void> check() const;
};

/// A method as a study ran it.
struct StudyMethod {
  RegistrationMethod method = RegistrationMethod::kField;
  std::string device = "cpu";
  double down_sampling = 1.0;
};

/// One pose registered. All errors are root mean squares.
struct StudyRun {
  double fre_mm = 0.0;           ///< Of the tagged markers, by Horn.
  double tagged_tre_mm = 0.0;    ///< At the five markers as tagged: what the paper calls TRE.
  double internal_tre_mm = 0.0;  ///< At places inside the body, against the truth.
  double start_tre_mm = 0.0;     ///< The same before registration.
  double registration_ms = 0.0;
  double cpu_ms = 0.0;  ///< Of the calling thread.
  int num_points = 0;
  int num_iterations = 0;
};

struct StudyColumn {
  StudyMethod method;
  std::vector<StudyRun> runs;  ///< One a pose.
  std::string not_run;         ///< Why there are none, else empty.

  /// Whether it ran and is none of the anisotropic ones, of which the paper printed nothing: those
  /// stand in the summaries only.
  [[nodiscard]] bool is_shown_by_pose() const {
    return !runs.empty() && method.method != RegistrationMethod::kAnisotropicIcp &&
           method.method != RegistrationMethod::kTrimmedAnisotropicIcp;
  }
};

struct Study {
  std::string name;    ///< "phantom".
  std::string camera;  ///< What `simulated:` would be told.
  int num_markers = 0;
  std::vector<StudyColumn> columns;
};

/// A recording of somebody else with a biased sensor, one method.
struct RecordedStudy {
  std::string recording;
  StudyMethod method;
  double success_rate = 0.0;
  Summary tre_mm;          ///< Over all runs, all targets.
  Summary tre_success_mm;  ///< Over the successes.
};

struct StudiesReport {
  StudiesOptions options;
  std::string case_name;
  Study phantom;                    ///< Table 1.
  Study post_mortem;                ///< Table 2.
  std::vector<Study> down_sampled;  ///< Table 3, one a factor.
  // Many poses, CPU, at a down-sampling of 2.5.
  Study many_plain;
  Study many_hand;
  Study many_parts;
  Study many_cluttered;  ///< Hand, towel and parts.
  Study biased;
  std::vector<RecordedStudy> recorded;
  std::vector<std::string> notes;  ///< What was left out, and why.
};

/// Other people's recordings, and the bodies that they may show.
struct RecordedData {
  std::filesystem::path folder;  ///< Those named `*_real` in it are run; empty: none.
  std::vector<Case> bodies;      ///< Besides the one under study.
};

/// Runs them all.
/// @param data  Recordings of none of the bodies are left out with a note.
/// @errors kInvalidArgument: bad options, a body on which no pose shows five markers; kIo.
[[nodiscard]] Result<StudiesReport> run_studies(const Case& body,
                                                const RecordedData& data,
                                                const StudiesOptions& options,
                                                const Progress& progress);

[[nodiscard]] std::string to_json(const StudiesReport& report);

}  // namespace mor
