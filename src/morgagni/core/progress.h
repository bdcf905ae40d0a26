// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace mor {

/// Told by long work where it is: the stage's name and its share done, 0 to 1. The stages come in
/// order, each ends with 1. Called from a thread that works, by one at a time. Throws nothing.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// Draws one line a stage with bar and seconds on standard error: redrawn in place on a terminal,
/// one finished line a stage elsewhere (logs, CI).
[[nodiscard]] Progress console_progress();

}  // namespace mor
