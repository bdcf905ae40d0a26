// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_decision.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr double kOpenShare = 0.6;
constexpr double kFloatingCost = 1.0;
constexpr double kHiddenCost = 0.02;

// Each of these refuses a pose alone. How they were found: docs/automatic-start.md.
constexpr double kMostFloating = 0.2;  ///< Of what agrees.
constexpr double kLeastHold = 5e-5;    ///< Share of the skin's area times firmness.
constexpr double kLeastPatches = 2.0;
constexpr double kMostUnevenMm = 1.15;        ///< In a picture, whatever its sensor's errors.
constexpr double kMostUnevenEvenedMm = 0.33;  ///< In the mean of several, without any noise,
constexpr double kMostUnevenNoise = 0.39;     ///< and what a reading's noise adds to it,
constexpr double kMostUnevenSeenMm = 0.64;    ///< up to where wrong poses begin.
constexpr double kMostlyAgrees = 0.85;        ///< Of what nothing hides,
constexpr double kHardlyAgrees = 0.35;        ///< or from here down.
constexpr double kRunnerUpDoubt = 0.4;        ///< What a runner-up of equal evidence weighs.
constexpr double kTriesDoubt = 0.05;          ///< Where it is not the first picture.
constexpr double kMostDoubt = 0.7;            ///< All together.
constexpr double kMostDoubtEvened = 0.7;      ///< In the mean of five,
constexpr double kNoiseDoubt = 0.577;         ///< and less for what noise is left of more.
constexpr double kLeastNoise = 0.447;         ///< Share left in the mean of five.
constexpr double kMostMirrored = 1.0;         ///< Where it fits as well, the CT may be mirrored.

struct Doubts {
  double floating = 0.0;
  double loose = 0.0;   ///< Skin too little or too round to hold a pose.
  double few = 0.0;     ///< Hardly any skin.
  double uneven = 0.0;  ///< Skin that agrees only so-so,
  double partly = 0.0;  ///< or not all that should.

  [[nodiscard]] double sum() const { return floating + loose + few + uneven + partly; }
};

constexpr double kBeyondMeasure = 1e3;
constexpr double kSaysEnough = 0.3;  ///< A doubt that explains a refusal.

double ratio(double part, double whole) {
  return whole > 0.0 ? std::min(kBeyondMeasure, part / whole) : kBeyondMeasure;
}

double open_share(const SkinAgreement& look) {
  return ratio(look.num_agree, look.num_seen - look.num_hidden);
}

/// In the mean of several pictures right poses and wrong ones are farther apart: a steeper doubt.
double uneven_doubt(const SkinAgreement& look) {
  if (look.noise_share >= 1.0) return std::pow(look.uneven_mm / kMostUnevenMm, 2);
  const double most_mm = std::min(
      kMostUnevenSeenMm,
      std::hypot(kMostUnevenEvenedMm, kMostUnevenNoise * look.noise_share * look.noise_mm));
  return std::pow(look.uneven_mm / most_mm, 4);
}

Doubts doubts_of(const SkinAgreement& look) {
  return {
      .floating = ratio(look.num_floating, look.num_agree) / kMostFloating,
      .loose = ratio(kLeastHold, look.area_share * look.firmness),
      .few = ratio(kLeastPatches, look.num_patches),
      .uneven = uneven_doubt(look),
      .partly = std::max(0.0, kMostlyAgrees - open_share(look)) / (kMostlyAgrees - kHardlyAgrees)};
}

std::string percent(double part, double whole) {
  return fmt::format("{:.0f} %", 100.0 * part / std::max(1.0, whole));
}

/// The refusal by the doubt that weighs most, in a sentence.
StartVerdict refused(const SkinAgreement& look) {
  const Doubts doubts = doubts_of(look);
  const bool has_much = doubts.few < kSaysEnough;  // Of hardly any skin nothing can be said.
  if (has_much && doubts.loose > std::max({kSaysEnough, doubts.floating, doubts.uneven})) {
    return {
        AutomaticStartStatus::kAmbiguous,
        fmt::format("the {:.0f} % of the skin that the camera measures would fit as well if the "
                    "body lay otherwise: show more of it",
                    100.0 * look.area_share)};
  }
  const std::string intro = "no pose explains the picture: at the best, ";
  if (has_much && doubts.floating > std::max(kSaysEnough, doubts.uneven)) {
    return {AutomaticStartStatus::kNotFound,
            intro + "the camera looks through " + percent(look.num_floating, look.num_seen) +
                " of the skin"};
  }
  if (has_much && doubts.uneven > kSaysEnough) {
    return {AutomaticStartStatus::kNotFound,
            intro + fmt::format("what looks like skin is {:.1f} mm off it here and there",
                                look.uneven_mm)};
  }
  return {AutomaticStartStatus::kNotFound,
          intro + percent(look.num_agree, look.num_seen - look.num_hidden) +
              " of the skin that nothing hides is seen where it should be, and " +
              percent(look.num_hidden, look.num_seen) + " is hidden"};
}

}  // namespace

double evidence(const SkinAgreement& agreement) {
  return agreement.num_agree - kOpenShare * (agreement.num_seen - agreement.num_hidden) -
         kFloatingCost * agreement.num_floating -
         kHiddenCost * agreement.noise_share * agreement.num_hidden;
}

double trust(const SkinAgreement& look) {
  if (!(evidence(look) > 0.0)) return -kBeyondMeasure;
  return 1.0 - doubts_of(look).sum();
}

double believed_evidence(const SkinAgreement& look) {
  const double speaks = evidence(look);
  if (!(speaks > 0.0)) return speaks - 1.0;
  // Without any trust still in order, below all that has some.
  const double believed = trust(look);
  return believed > 0.0 ? believed * speaks : std::max(-1.0, believed / kBeyondMeasure);
}

double margin(const SkinAgreement& look, double runner_up_share, std::size_t num_tries) {
  const double most_doubt = look.noise_share < 1.0
                                ? kMostDoubtEvened - kNoiseDoubt * (look.noise_share - kLeastNoise)
                                : kMostDoubt - (num_tries > 1 ? kTriesDoubt : 0.0);
  return trust(look) - kRunnerUpDoubt * runner_up_share - (1.0 - most_doubt);
}

StartVerdict decide_start(const StartCase& best) {
  const double left = margin(best.look, best.runner_up_share, best.num_tries);
  if (margin(best.look, 0.0, best.num_tries) < 0.0) return refused(best.look);
  if (left < 0.0) {
    return {AutomaticStartStatus::kAmbiguous,
            fmt::format("another pose explains the picture {:.0f} % as well: show more of the body",
                        100.0 * best.runner_up_share)};
  }
  // Where it fits less well it is a rival like any other.
  if (best.mirrored_share >= kMostMirrored || left < kRunnerUpDoubt * best.mirrored_share) {
    return {AutomaticStartStatus::kAmbiguous,
            "the CT's mirror image explains the picture too: show more of the body, and if that "
            "does not help, see whether the CT is the right way round"};
  }
  return {AutomaticStartStatus::kFound, {}};
}

}  // namespace mor::internal
