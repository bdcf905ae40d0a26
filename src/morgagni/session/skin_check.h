// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "morgagni/casefile/prepare.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// What is made of the CT when people agree with what they see.
using UseBody =
    std::function<Result<PrepareSummary>(const PrepareOptions& options, const Progress& progress)>;

struct SkinCheckOptions {
  std::string title;       ///< Of the page: the case's name.
  PrepareOptions prepare;  ///< To begin with.
  LiveServerOptions server;
};

/// A page on which the skin is checked and corrected before a case is made of it: slices, the skin
/// to turn, what was cut, thresholds. Nothing is written before "Use it" is pressed.
class SkinCheck {
 public:
  /// @errors As LiveServer's and BodyCheck's.
  [[nodiscard]] static Result<std::unique_ptr<SkinCheck>> start(
      std::shared_ptr<const Volume> volume, UseBody use, const SkinCheckOptions& options);
  virtual ~SkinCheck() = default;

  [[nodiscard]] virtual std::uint16_t port() const = 0;

  /// Until the case is made, or people cancel, or a stop is asked for.
  /// @return The case's summary; none: nothing was made.
  [[nodiscard]] virtual std::optional<PrepareSummary> wait(std::stop_token stop) = 0;
};

}  // namespace mor
