// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "morgagni/calibration/self_calibration.h"
#include "morgagni/camera/depth_correction.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/result.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

/// Frames of a recording whose poses and targets are known, in the case's frame.
struct RecordedFrames {
  struct Frame {
    Image<std::uint16_t> depth_mm;
    Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();  ///< The truth.
  };
  PinholeCamera depth;
  std::vector<Frame> frames;
  std::vector<Target> targets;
};

/// A TUM folder with groundtruth.txt and targets.csv. @errors As their readers'.
[[nodiscard]] Result<RecordedFrames> load_recorded_frames(const std::filesystem::path& folder,
                                                          const Case& body);

/// A recorded sensor's systematic error of depth and how the recorded body has changed since its
/// CT, as the frames show both at their true poses.
struct RecordedBias {
  /// What the sensor adds to a true distance: apply() makes a true picture the sensor's.
  DepthCorrection adds;
  DepthCorrection removes;  ///< Takes it back.
  bool is_growing = false;  ///< With the distance; else it is the same at each.
  SkinChange body;
  double body_mm = 0.0;  ///< Root mean square of the body's change where it was read.
  int num_readings = 0;
  double before_mm = 0.0;        ///< Of the readings less the truth, robust root mean square,
  double without_adds_mm = 0.0;  ///< less the sensor's error,
  double after_mm = 0.0;         ///< and less the body's change as well.
};

/// Fits to the readings on the skin, together, a polynomial of third degree over the picture and a
/// smooth displacement of the skin, fixed on the body; once with the sensor's error growing with
/// the distance and once the same at each, and takes what fits better. For evaluation alone: it
/// needs the truth. @errors kInvalidArgument: too few readings on the skin.
[[nodiscard]] Result<RecordedBias> measure_bias(const TriangleMesh& skin,
                                                const RecordedFrames& recorded);

}  // namespace mor
