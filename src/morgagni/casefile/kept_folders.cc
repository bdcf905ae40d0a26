// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/kept_folders.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/added_cts.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> cannot_keep(const fs::path& path, const std::error_code& status) {
  return make_error(ErrorCode::kIo,
                    fmt::format("{}: cannot be kept in the new case, which is not made: {}",
                                path.string(),
                                status.message()));
}

/// One entry; the entries of a folder follow by themselves.
std::error_code carry_over(const fs::directory_entry& entry, const fs::path& to) {
  std::error_code status;
  if (entry.is_symlink()) {
    fs::copy_symlink(entry.path(), to, status);
  } else if (entry.is_directory()) {
    fs::create_directory(to, entry.path(), status);
  } else {
    fs::create_hard_link(entry.path(), to, status);
    if (status) fs::copy_file(entry.path(), to, status);  // No hard links here: FAT, some networks.
  }
  return status;
}

}  // namespace

bool has_kept_files(const fs::path& case_folder) {
  const bool has_made =
      std::any_of(kKeptFolders.begin(), kKeptFolders.end(), [&](const char* name) {
        std::error_code status;
        const fs::path folder = case_folder / name;
        return fs::exists(fs::symlink_status(folder, status)) && !fs::is_empty(folder, status);
      });
  return has_made || !added_cts(case_folder).empty();
}

Result<void> carry_over_kept_folders(const fs::path& from_case, const fs::path& to_case) {
  std::vector<const char*> names(kKeptFolders.begin(), kKeptFolders.end());
  names.push_back(kAddedCtsFolder);
  for (const char* const name : names) {
    const fs::directory_entry top(from_case / name);
    std::error_code status;
    if (!fs::exists(top.symlink_status(status))) continue;
    if (status = carry_over(top, to_case / name); status) return cannot_keep(top.path(), status);
    if (top.is_symlink() || !top.is_directory()) continue;
    fs::recursive_directory_iterator entry(top.path(), status);
    for (; !status && entry != fs::recursive_directory_iterator(); entry.increment(status)) {
      const auto failed = carry_over(*entry, to_case / entry->path().lexically_relative(from_case));
      if (failed) return cannot_keep(entry->path(), failed);
    }
    if (status) return cannot_keep(top.path(), status);
  }
  return {};
}

}  // namespace mor
