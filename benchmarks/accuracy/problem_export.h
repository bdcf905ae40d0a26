// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "morgagni/casefile/case.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"

namespace mor::peers {

/// Where the runs of a set start.
enum class StartKind : std::uint8_t {
  kRough,    ///< The truth, disturbed as by landmarks or a placement.
  kTracked,  ///< The truth, disturbed as by one frame's motion.
  kNone,     ///< Nowhere: global registration. Who takes the cloud instead of the picture is shown
             ///< the body cut out where it truly is.
};

struct ExportOptions {
  BodySurfaceOptions depth = {};
  StartKind start = StartKind::kRough;
  int num_frames = 20;           ///< Spread evenly over the recording.
  int num_starts = 20;           ///< A frame; one for kNone.
  double start_error_mm = 30.0;  ///< As in EvaluationOptions.
  double start_error_deg = 20.0;
  std::uint64_t seed = 1;
};

/// Writes what every method is given, read again by read_problems(): the skin, each frame's
/// clouds as PLY, and problems.json with starts, truths and targets.
/// @param recording  A TUM folder with groundtruth.txt and targets.csv.
/// @errors whatever the readers report; kInvalidArgument: a frame that shows no surface.
[[nodiscard]] Result<void> export_problems(const std::filesystem::path& out,
                                           const Case& body,
                                           const std::filesystem::path& recording,
                                           const ExportOptions& options);

/// The same for a set with a known answer: the moving clouds are vertices of the skin itself, seen
/// from in front, and each frame starts once from the truth and once 3 mm / 1 degree off it.
[[nodiscard]] Result<void> export_exact_problems(const std::filesystem::path& out,
                                                 const Case& body);

}  // namespace mor::peers
