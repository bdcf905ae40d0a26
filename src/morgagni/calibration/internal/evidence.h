// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/calibration/internal/bundle.h"
#include "morgagni/calibration/self_calibration.h"

namespace mor::internal {

/// What a model leaves of views that were held out, fold by fold.
struct HeldOutRest {
  std::vector<ViewFit> folds;

  [[nodiscard]] double mm() const;
};

[[nodiscard]] HeldOutGain gain_of(const HeldOutRest& better, const HeldOutRest& worse);

/// Whether the sensor errs, by all but the verdict.
[[nodiscard]] SelfCalibrationVerdict judge_sensor(const SelfCalibration& found,
                                                  const SelfCalibrationOptions& options);

/// Whether held-out views speak for a change of the skin where the sensor is left as it is, before
/// it is asked how large that change is.
[[nodiscard]] bool speaks_for_skin_alone(const SelfCalibration& found);

/// Whether following the skin is proposed, along with `found.verdict` on the sensor or in its
/// place.
void judge_skin(const SelfCalibrationOptions& options, SelfCalibration& found);

}  // namespace mor::internal
