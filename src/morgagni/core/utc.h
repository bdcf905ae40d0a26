// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>

#include "morgagni/core/result.h"

namespace mor {

/// ISO 8601 in UTC, to the second: "2026-11-26T16:20:05Z".
[[nodiscard]] std::string utc_text(
    std::chrono::system_clock::time_point time = std::chrono::system_clock::now());

/// What utc_text() writes. @errors kInvalidArgument: says what it is not.
[[nodiscard]] Result<std::chrono::system_clock::time_point> parse_utc(const std::string& text);

}  // namespace mor
