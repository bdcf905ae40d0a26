// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/evidence.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mor::internal {
namespace {

/// Corrections that move the body by up to so much were found without any error of the sensor, too:
/// what noise model and skin leave. Smaller ones would make one body in three worse,
constexpr double kLeastShiftMm = 1.0;
/// but where held-out views gain so much, which they never did without such an error.
constexpr double kLargeGain = 0.05;
constexpr double kLeastSureShiftMm = 0.5;
/// Where more than this share of what a sensor can do to a pose stays unknown, the camera has moved
/// too little.
constexpr double kMostOpenShare = 0.6;
/// A shift of more than so many of the prior's standard deviations is none of a sensor's.
constexpr double kMostPlausible = 2.5;
constexpr double kLeastSignificance = 3.0;
constexpr double kLeastGain = 0.01;
/// Held-out views gain so much where the skin has changed. An error of the sensor that is too small
/// to be proposed gains 2 to 3 % by a change of the skin as well.
constexpr double kLeastSkinGain = 0.05;
/// More of its prior's standard deviation, root mean square, is another body, or a cover.
constexpr double kMostSkin = 0.75;
/// A changed skin that moves the poses by less is as in the CT.
constexpr double kLeastSkinShiftMm = 0.3;

double mean_sq_mm2(const ViewFit& fit) {
  return fit.sum_sq_mm2 / std::max(1e-9, fit.sum_weights);
}

bool is_sure(const HeldOutFit& held, const HeldOutGain& gain, double least_share) {
  // Parts of a motion tell unequally much: where all of them gain they need not gain alike.
  const bool is_in_all = gain.num_better == held.num_folds;
  const bool is_even =
      gain.num_better + 1 == held.num_folds && gain.significance > kLeastSignificance;
  return gain.share > least_share && (is_in_all || is_even);
}

}  // namespace

double HeldOutRest::mm() const {
  ViewFit all;
  for (const auto& fold : folds) {
    all.sum_sq_mm2 += fold.sum_sq_mm2;
    all.sum_weights += fold.sum_weights;
  }
  return std::sqrt(mean_sq_mm2(all));
}

HeldOutGain gain_of(const HeldOutRest& better, const HeldOutRest& worse) {
  HeldOutGain gain;
  gain.share = 1.0 - better.mm() / worse.mm();
  std::vector<double> gains;
  for (std::size_t i = 0; i < better.folds.size(); ++i) {
    gains.push_back(mean_sq_mm2(worse.folds[i]) - mean_sq_mm2(better.folds[i]));
    if (gains.back() > 0.0) ++gain.num_better;
  }
  const auto count = static_cast<double>(gains.size());
  const double mean = std::accumulate(gains.begin(), gains.end(), 0.0) / count;
  double squares = 0.0;
  for (const double one : gains) squares += (one - mean) * (one - mean);
  gain.significance = mean / std::max(1e-9, std::sqrt(squares / (count * (count - 1.0))));
  return gain;
}

SelfCalibrationVerdict judge_sensor(const SelfCalibration& found,
                                    const SelfCalibrationOptions& options) {
  // So far off is no sensor: a cover, or another body.
  const bool is_plausible = found.shift_mm < kMostPlausible * found.before_mm;
  if (!is_sure(found.held_out, found.held_out.sensor, kLeastGain) || !is_plausible) {
    return SelfCalibrationVerdict::kNoError;
  }
  // Less is told apart from the sensor by the views that were held out.
  if (found.skin_rms_mm > kMostSkin * options.skin_mm) return SelfCalibrationVerdict::kOtherBody;
  if (found.open_share > kMostOpenShare) return SelfCalibrationVerdict::kTooLittleMotion;
  const double least_mm =
      found.held_out.sensor.share > kLargeGain ? kLeastSureShiftMm : kLeastShiftMm;
  return found.shift_mm < least_mm ? SelfCalibrationVerdict::kSmall
                                   : SelfCalibrationVerdict::kError;
}

bool speaks_for_skin_alone(const SelfCalibration& found) {
  const auto& held = found.held_out;
  // Where the sensor's error is there but not proposed, a changed skin would be taken for it.
  const bool sensor_is_fine = found.verdict == SelfCalibrationVerdict::kNoError ||
                              found.verdict == SelfCalibrationVerdict::kSmall;
  return sensor_is_fine && held.skin_mm < held.sensor_mm &&
         is_sure(held, held.skin, kLeastSkinGain);
}

void judge_skin(const SelfCalibrationOptions& options, SelfCalibration& found) {
  const auto& held = found.held_out;
  const auto& gain = found.corrects_sensor() ? held.skin_and_sensor : held.skin;
  if (!is_sure(held, gain, kLeastSkinGain) || found.skin_shift_mm < kLeastSkinShiftMm) return;
  if (found.skin_rms_mm > kMostSkin * options.skin_mm) {
    found.verdict = SelfCalibrationVerdict::kOtherBody;
    return;
  }
  found.follows_skin = true;
  if (!found.corrects_sensor()) found.verdict = SelfCalibrationVerdict::kSkinChanged;
}

}  // namespace mor::internal
