// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/spdlog.h>

/// Logging is spdlog: `mor::log::warn("camera {} is gone", name)`. To standard error, one line
/// each.
namespace mor::log {

using spdlog::debug;
using spdlog::error;
using spdlog::info;
using spdlog::warn;

/// Sends the log to standard error as `[time] [level] text`. Call once, at the top of main().
void set_up(bool verbose);

}  // namespace mor::log
