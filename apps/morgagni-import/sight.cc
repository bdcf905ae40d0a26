// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sight.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace mor::import {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kReading = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
/// All that the first version of Landlock knows.
constexpr std::uint64_t kEverything = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1U) - 1;

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

void show(int rules, const fs::path& path) {
  const int fd = ::open(path.c_str(), O_PATH | O_CLOEXEC);
  if (fd < 0) return;
  std::error_code failure;
  const bool is_folder = fs::is_directory(path, failure);
  const landlock_path_beneath_attr beneath = {
      is_folder ? kReading : std::uint64_t{LANDLOCK_ACCESS_FS_READ_FILE}, fd};
  (void)::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0);
  ::close(fd);
}

}  // namespace

void see_only(const fs::path& path) {
  const landlock_ruleset_attr handled = {kEverything};
  const int rules =
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, sizeof(handled), 0));
  if (rules < 0) return;
  std::error_code failure;
  show(rules, path);
  if (fs::is_directory(path, failure)) {
    for (const auto& file : linked_files(path)) show(rules, file);
  } else if (names_other_files(path)) {
    show(rules, path.has_parent_path() ? path.parent_path() : fs::path("."));
  }
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  (void)::syscall(SYS_landlock_restrict_self, rules, 0);
  ::close(rules);
}

}  // namespace mor::import
