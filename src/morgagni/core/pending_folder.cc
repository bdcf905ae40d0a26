// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/pending_folder.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".part-";

tl::unexpected<Error> cannot_write(const fs::path& path, const std::string& why) {
  return make_error(ErrorCode::kIo, fmt::format("{}: cannot be written: {}", path.string(), why));
}

bool is_running(std::string_view pid_text) {
  pid_t pid = 0;
  const auto [end, error] =
      std::from_chars(pid_text.data(), pid_text.data() + pid_text.size(), pid);
  return error == std::errc() && (kill(pid, 0) == 0 || errno == EPERM);
}

/// Removes the pending folders of runs that are gone.
void sweep(const fs::path& target) {
  const std::string prefix = target.filename().string() + std::string(kSuffix);
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(target.parent_path(), status)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(prefix) && !is_running(std::string_view(name).substr(prefix.size()))) {
      fs::remove_all(entry.path(), status);
    }
  }
}

}  // namespace

Result<PendingFolder> PendingFolder::create(const fs::path& target) {
  std::error_code status;
  fs::path absolute = fs::absolute(target, status).lexically_normal();
  if (!absolute.has_filename()) absolute = absolute.parent_path();  // "case/" means "case".
  fs::create_directories(absolute.parent_path(), status);
  if (status) return cannot_write(absolute.parent_path(), status.message());
  sweep(absolute);
  fs::path path = absolute.string() + fmt::format("{}{}", kSuffix, getpid());
  fs::remove_all(path, status);
  if (!fs::create_directory(path, status)) return cannot_write(path, status.message());
  return PendingFolder(std::move(absolute), std::move(path));
}

PendingFolder::PendingFolder(fs::path target, fs::path path)
    : target_(std::move(target)), path_(std::move(path)) {}

PendingFolder::PendingFolder(PendingFolder&& other) noexcept
    : target_(std::move(other.target_)), path_(std::exchange(other.path_, {})) {}

PendingFolder::~PendingFolder() {
  std::error_code status;
  if (!path_.empty()) fs::remove_all(path_, status);
}

Result<void> PendingFolder::commit() {
  const bool replaces = fs::exists(target_);
  const unsigned flags = replaces ? RENAME_EXCHANGE : RENAME_NOREPLACE;
  if (renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), flags) != 0) {
    return cannot_write(target_, std::strerror(errno));
  }
  if (!replaces) path_.clear();  // Else it now holds the old folder, which the destructor removes.
  return {};
}

}  // namespace mor
