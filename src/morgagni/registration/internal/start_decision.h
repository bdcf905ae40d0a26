// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/internal/start_verification.h"

namespace mor::internal {

/// What speaks for a pose less what speaks against it, in parts of the skin. At the right pose the
/// skin that nothing hides agrees to the noise; another surface like a towel may run near more of
/// the skin, but not as close.
[[nodiscard]] double evidence(const SkinAgreement& agreement);

/// How far a pose may be believed after a look, 1 at the most: 1 less the doubts, each of which
/// would refuse it alone at 1. At 0 and below: not at all.
[[nodiscard]] double trust(const SkinAgreement& look);

/// Its rank among poses that were looked at: evidence, as far as it may be believed.
[[nodiscard]] double believed_evidence(const SkinAgreement& look);

/// The best pose among its rivals.
struct StartCase {
  SkinAgreement look;
  double runner_up_share = 0.0;  ///< Of its believed evidence, what the best pose elsewhere has.
  double mirrored_share = 0.0;   ///< Likewise, what the CT's mirror image has.
  std::size_t num_tries = 1;     ///< Pictures so far in which a pose might have been believed.
};

/// By how much it passes; negative: it does not. More tries are more chances to be wrong, so that
/// later ones must be better than a first.
[[nodiscard]] double margin(const SkinAgreement& look,
                            double runner_up_share,
                            std::size_t num_tries);

struct StartVerdict {
  AutomaticStartStatus status = AutomaticStartStatus::kNotFound;
  std::string reason;  ///< As in AutomaticStartResult.
};
[[nodiscard]] StartVerdict decide_start(const StartCase& best);

}  // namespace mor::internal
