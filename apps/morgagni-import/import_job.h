// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor::import {

/// What the program was asked for (morgagni/ct/import_protocol.h).
struct ImportJob {
  std::string_view task;
  std::filesystem::path path;
  std::string series;
};

/// Reads what the job names and hands it over. What a library throws becomes a sentence too.
[[nodiscard]] Result<void> do_job(const ImportJob& job);

}  // namespace mor::import
