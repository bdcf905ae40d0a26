// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/open_paths.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/syscall.h>

#include "morgagni/core/unique_fd.h"

namespace mor {
namespace {

/// All that the first version of Landlock knows.
constexpr std::uint64_t kFirstVersion = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1U) - 1;
constexpr std::uint64_t kTruncate = 1ULL << 14U;  ///< Since version 3, newer than some headers.

constexpr std::uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kChangeFile = kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
constexpr std::uint64_t kReadFolder = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kChangeFolder =
    kReadFolder | kChangeFile | LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_MAKE_DIR |
    LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_REFER;

void allow(int rules, const OpenPath& what, std::uint64_t handled) {
  const UniqueFd fd(::open(what.path.c_str(), O_PATH | O_CLOEXEC));
  if (fd.get() < 0) return;
  std::error_code failure;
  const bool is_folder = std::filesystem::is_directory(what.path, failure);
  const std::uint64_t rights = is_folder ? (what.may_change ? kChangeFolder : kReadFolder)
                                         : (what.may_change ? kChangeFile : kReadFile);
  const landlock_path_beneath_attr beneath = {rights & handled, fd.get()};
  (void)::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0);
}

tl::unexpected<Error> unsupported(const std::string& why) {
  return make_error(ErrorCode::kUnsupported, "Landlock: " + why);
}

tl::unexpected<Error> failed() {
  return unsupported(std::generic_category().message(errno));
}

}  // namespace

Result<void> open_only(const std::vector<OpenPath>& paths) {
  const auto version =
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return failed();
  const bool changes =
      std::any_of(paths.begin(), paths.end(), [](const OpenPath& what) { return what.may_change; });
  if (changes && version < 2) return unsupported("version 1 moves no file to another folder");
  const std::uint64_t handled = kFirstVersion | (version >= 2 ? LANDLOCK_ACCESS_FS_REFER : 0) |
                                (version >= 3 ? kTruncate : 0);
  const landlock_ruleset_attr attributes = {handled};
  const UniqueFd rules(
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &attributes, sizeof(attributes), 0)));
  if (rules.get() < 0) return failed();
  for (const auto& what : paths) allow(rules.get(), what, handled);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) return failed();
  return {};
}

}  // namespace mor
