// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"

/// What this process says to its parent (morgagni/pacs/dimse_protocol.h).
namespace mor::dimse {

using Tags = std::map<std::string, std::string>;

void say_match(const Tags& tags);
void say_stored(std::string_view file, std::uint64_t bytes, const Tags& tags);
void say_caller(std::string_view aet);
/// Of a limit of this process that does not hold on this machine.
void say_weakness(std::string_view sentence);
void say_refused(std::string_view why);
void say_done(int num_failed);
void say_failed(const Error& error);

}  // namespace mor::dimse
