// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sight.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "morgagni/core/open_paths.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

bool names_other_files(const fs::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return name.ends_with(".mhd") || name.ends_with(".nhdr") ||
         name.find("dicomdir") != std::string::npos;
}

/// Links to files, as they gather a series from an archive.
std::vector<fs::path> linked_files(const fs::path& folder) {
  constexpr std::size_t kMaxLinks = 20000;
  std::vector<fs::path> files;
  std::error_code failure;
  constexpr auto kOptions = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator it(folder, kOptions, failure), end;
       !failure && it != end && files.size() < kMaxLinks;
       it.increment(failure)) {
    std::error_code no_link;
    if (it->is_symlink(no_link) && it->is_regular_file(no_link)) files.push_back(it->path());
  }
  return files;
}

}  // namespace

Result<void> see_only(const fs::path& path) {
  std::vector<OpenPath> visible = {{path}};
  std::error_code failure;
  if (fs::is_directory(path, failure)) {
    for (auto& file : linked_files(path)) visible.push_back({std::move(file)});
  } else if (names_other_files(path)) {
    visible.push_back({path.has_parent_path() ? path.parent_path() : fs::path(".")});
  }
  return open_only(visible);
}

}  // namespace mor::import
