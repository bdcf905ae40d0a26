// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/volume_import.h"

#include <chrono>
#include <system_error>

#include "morgagni/ct/internal/import_process.h"

namespace mor {

Result<Volume> import_volume(const std::filesystem::path& path, const Progress& progress) {
  constexpr std::chrono::seconds kTimeLimit{600};
  std::error_code failure;
  if (!std::filesystem::exists(path, failure))
    return make_error(ErrorCode::kNotFound, "there is no file or folder " + path.string());
  MOR_TRY(const auto program, internal::find_import_program());
  return internal::run_import_process(program, path, kTimeLimit, progress);
}

}  // namespace mor
