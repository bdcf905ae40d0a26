// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>

namespace mor::log {

void set_up(bool verbose) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("morgagni"));
  spdlog::set_pattern("[%H:%M:%S.%e] [%^%l%$] %v");
  spdlog::set_level(verbose ? spdlog::level::debug : spdlog::level::info);
}

}  // namespace mor::log
