// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>

#include "morgagni/core/result.h"

namespace mor {

inline constexpr int kExitFailure = 1;
inline constexpr int kExitUsage = 2;

/// The value, or the program's end: prints the sentence and exits with 1.
template <class T>
T value_or_exit(Result<T> result) {
  if (!result) {
    fmt::print(stderr, "morgagni: {}\n", result.error().message);
    throw CLI::RuntimeError(kExitFailure);
  }
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// Makes the folder that results go to; before the work, not after it.
inline void make_folder_or_exit(const std::filesystem::path& folder) {
  std::error_code status;
  std::filesystem::create_directories(folder, status);
  if (!status) return;
  value_or_exit(Result<void>(
      tl::unexpect,
      Error{ErrorCode::kIo, fmt::format("{}: {}", folder.string(), status.message())}));
}

}  // namespace mor
