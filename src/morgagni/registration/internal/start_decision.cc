// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_decision.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr double kOpenShare = 0.6;
constexpr double kFloatingCost = 2.0;
constexpr double kHiddenCost = 0.02;
constexpr double kDepartingCost = 1.5;

// Each of these refuses a pose alone. How they were found: docs/automatic-start.md.
constexpr double kMostFloating = 0.15;     ///< Of what agrees.
constexpr double kMostDeparting = 0.12;    ///< Likewise.
constexpr double kLeastHold = 1e-4;        ///< Share of the skin's area times firmness.
constexpr double kLeastAgree = 60.0;       ///< Pixels.
constexpr double kLeastEvidence = 0.03;    ///< Of what agrees.
constexpr double kRunnerUpDoubt = 0.4;     ///< What a runner-up of equal evidence weighs.
constexpr double kMostDoubt = 0.75;        ///< All together,
constexpr double kMostPartlyDoubt = 0.45;  ///< or, where not nearly all agrees that nothing hides.
constexpr double kNearlyAll = 0.9;
/// The mirror image must not fit better: then the CT may be mirrored, or the body is turned. Nearly
/// as well is a doubt too: what agrees is round enough to agree with much.
constexpr double kMostMirrored = 1.0;
constexpr double kNearlyMirrored = 0.8;
constexpr double kMirrorDoubt = 0.4;  ///< What a mirror image of equal evidence weighs.

struct Doubts {
  double floating = 0.0;
  double departing = 0.0;
  double loose = 0.0;  ///< Skin too little or too round to hold a pose.
  double small = 0.0;
  double vague = 0.0;  ///< Skin that agrees only so-so.

  [[nodiscard]] double sum() const { return floating + departing + loose + small + vague; }
};

constexpr double kBeyondMeasure = 1e3;
constexpr double kSaysEnough = 0.3;  ///< A doubt that explains a refusal.

double ratio(double part, double whole) {
  return whole > 0.0 ? std::min(kBeyondMeasure, part / whole) : kBeyondMeasure;
}

Doubts doubts_of(const SkinAgreement& look) {
  return {.floating = ratio(look.num_floating, look.num_agree) / kMostFloating,
          .departing = ratio(look.num_departing, look.num_agree) / kMostDeparting,
          .loose = ratio(kLeastHold, look.area_share * look.firmness),
          .small = ratio(kLeastAgree, look.num_agree),
          .vague = ratio(kLeastEvidence * look.num_agree, evidence(look))};
}

double mirror_doubt(double mirrored_share) {
  const double nearness = (mirrored_share - kNearlyMirrored) / (kMostMirrored - kNearlyMirrored);
  return kMirrorDoubt * std::clamp(nearness, 0.0, 1.0);
}

/// A head laid into a shoulder agrees with a part of what nothing hides, too.
bool agrees_nearly_wholly(const SkinAgreement& look) {
  return look.num_agree >= kNearlyAll * (look.num_seen - look.num_hidden);
}

std::string percent(double part, double whole) {
  return fmt::format("{:.0f} %", 100.0 * part / std::max(1.0, whole));
}

/// The refusal by the doubt that weighs most, in a sentence.
StartVerdict refused(const SkinAgreement& look) {
  const Doubts doubts = doubts_of(look);
  // Of hardly any skin nothing can be said; and vagueness follows from the others too.
  const double most =
      look.num_agree < kLeastAgree ? 0.0 : std::max(doubts.floating, doubts.departing);
  if (look.num_agree >= kLeastAgree && doubts.loose > std::max(kSaysEnough, most)) {
    return {
        AutomaticStartStatus::kAmbiguous,
        fmt::format("the {:.0f} % of the skin that the camera measures would fit as well if the "
                    "body lay otherwise: show more of it",
                    100.0 * look.area_share)};
  }
  const std::string intro = "no pose explains the picture: at the best, ";
  if (most > kSaysEnough && most == doubts.floating) {
    return {AutomaticStartStatus::kNotFound,
            intro + "the camera looks through " + percent(look.num_floating, look.num_seen) +
                " of the skin"};
  }
  if (most > kSaysEnough) {
    return {AutomaticStartStatus::kNotFound,
            intro + "what hides the skin runs on from it without an edge, as another body would"};
  }
  return {AutomaticStartStatus::kNotFound,
          intro + percent(look.num_agree, look.num_seen - look.num_hidden) +
              " of the skin that nothing hides is seen where it should be, and " +
              percent(look.num_hidden, look.num_seen) + " is hidden"};
}

}  // namespace

double evidence(const SkinAgreement& agreement) {
  return agreement.num_agree - kOpenShare * (agreement.num_seen - agreement.num_hidden) -
         kFloatingCost * agreement.num_floating - kHiddenCost * agreement.num_hidden -
         kDepartingCost * agreement.num_departing;
}

double trust(const SkinAgreement& look) {
  if (!(evidence(look) > 0.0)) return -kBeyondMeasure;
  return 1.0 - doubts_of(look).sum();
}

double believed_evidence(const SkinAgreement& look) {
  // Without any trust still in order, below all that has some.
  const double believed = trust(look);
  return believed > 0.0 ? believed * evidence(look) : std::min(0.0, evidence(look));
}

double margin(const SkinAgreement& look, double runner_up_share) {
  return trust(look) - kRunnerUpDoubt * runner_up_share - (1.0 - kMostDoubt);
}

StartVerdict decide_start(const StartCase& best) {
  if (margin(best.look, 0.0) < 0.0) return refused(best.look);
  if (margin(best.look, best.runner_up_share) < 0.0) {
    return {AutomaticStartStatus::kAmbiguous,
            fmt::format("another pose explains the picture {:.0f} % as well: show more of the body",
                        100.0 * best.runner_up_share)};
  }
  if (!agrees_nearly_wholly(best.look) &&
      margin(best.look, best.runner_up_share) < kMostDoubt - kMostPartlyDoubt) {
    return {AutomaticStartStatus::kAmbiguous,
            fmt::format("only {} of the skin that nothing hides is seen where it should be: show "
                        "more of the body",
                        percent(best.look.num_agree, best.look.num_seen - best.look.num_hidden))};
  }
  if (best.mirrored_share >= kMostMirrored ||
      margin(best.look, best.runner_up_share) < mirror_doubt(best.mirrored_share)) {
    return {
        AutomaticStartStatus::kAmbiguous,
        "the CT's mirror image explains the picture as well: show more of the body, and if that "
        "does not help, see whether the CT is the right way round"};
  }
  return {AutomaticStartStatus::kFound, {}};
}

}  // namespace mor::internal
