// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/calibration/depth_readings.h"
#include "morgagni/camera/depth_correction.h"
#include "morgagni/core/result.h"

namespace mor {

/// Which of a DepthCorrection's coefficients are free.
enum class DepthForm : std::uint8_t {
  kAuto,          ///< Of the two below, the one that does better on views it has not seen.
  kDisparity,     ///< Structured light, linear in disparity: c1 and c2 over the picture.
  kTimeOfFlight,  ///< c0 over the picture, and one curve over the distance.
};

[[nodiscard]] std::string_view to_string(DepthForm form);

struct DepthFitOptions {
  DepthForm form = DepthForm::kAuto;
  int columns = 7;                ///< Of control points. 2..16.
  int rows = 6;                   ///< 2..16.
  int min_distances = 4;          ///< Distances more than 6 % apart from each other. >= 2.
  double min_far_to_near = 1.35;  ///< Of the readings' distances.
  double min_coverage =
      0.5;  ///< Share of the picture, in tiles, that must be seen at two distances.
};

/// Over what the depth was read.
struct DepthSpan {
  int num_distances = 0;
  double coverage = 0.0;  ///< Share of the picture, in tiles, that was read at two distances.
};

/// @param readings  `true_mm` need be right roughly only.
/// @errors kInvalidArgument: too few distances, or too little of the picture, for a correction;
/// says
///         what to add.
[[nodiscard]] Result<DepthSpan> depth_span(const std::vector<DepthReading>& readings,
                                           int width_px,
                                           int height_px,
                                           const DepthFitOptions& options = {});

/// What was found of the depth's error.
struct DepthFit {
  DepthCorrection correction;
  DepthForm form = DepthForm::kDisparity;
  DepthSpan span;
  /// Of a view whose depth was held out of the fit, the median one: readings less truth,
  double rms_before_mm = 0.0;
  double rms_after_mm = 0.0;  ///< and corrected readings less truth.
  /// Whether the correction helps on views it has not seen; else the readings are as good without.
  [[nodiscard]] bool helps() const { return rms_after_mm < 0.9 * rms_before_mm; }
};

}  // namespace mor
