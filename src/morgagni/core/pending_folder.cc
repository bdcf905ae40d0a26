// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/pending_folder.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <spdlog/fmt/fmt.h>
#include <sys/wait.h>
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

Result<PendingFolder> PendingFolder::create(const fs::path& target, WhenKilled when_killed) {
  std::error_code status;
  fs::path absolute = fs::absolute(target, status).lexically_normal();
  if (!absolute.has_filename()) absolute = absolute.parent_path();  // "case/" means "case".
  fs::create_directories(absolute.parent_path(), status);
  if (status) return cannot_write(absolute.parent_path(), status.message());
  sweep(absolute);
  fs::path path = absolute.string() + fmt::format("{}{}", kSuffix, getpid());
  fs::remove_all(path, status);
  PendingFolder pending(std::move(absolute), std::move(path));
  // Before there is a folder, so that at no moment it is unwatched.
  if (when_killed == WhenKilled::kRemove) pending.start_watcher();
  if (!fs::create_directory(pending.path_, status))
    return cannot_write(pending.path_, status.message());
  return pending;
}

PendingFolder::PendingFolder(fs::path target, fs::path path)
    : target_(std::move(target)), path_(std::move(path)) {}

PendingFolder::PendingFolder(PendingFolder&& other) noexcept
    : target_(std::move(other.target_)),
      path_(std::exchange(other.path_, {})),
      watcher_fd_(std::exchange(other.watcher_fd_, -1)),
      watcher_pid_(std::exchange(other.watcher_pid_, -1)) {}

PendingFolder::~PendingFolder() {
  std::error_code status;
  if (!path_.empty()) fs::remove_all(path_, status);
  dismiss_watcher();
}

void PendingFolder::start_watcher() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);
  // In a session of its own: what a terminal sends to this process's group is not for it.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  const std::string script = "read -r word; [ \"$word\" = kept ] || rm -rf -- \"$1\"";
  std::string folder = path_.string();
  std::array<std::string, 4> words = {"sh", "-c", script, "pending-folder"};
  std::array<char*, 6> arguments = {
      words[0].data(), words[1].data(), words[2].data(), words[3].data(), folder.data(), nullptr};
  if (::posix_spawn(&watcher_pid_, "/bin/sh", &actions, &attributes, arguments.data(), environ) !=
      0)
    watcher_pid_ = -1;
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  watcher_fd_ = ends[1];
}

void PendingFolder::dismiss_watcher() {
  if (watcher_fd_ < 0) return;
  constexpr std::string_view kWord = "kept\n";
  const bool told = ::write(watcher_fd_, kWord.data(), kWord.size()) > 0;
  ::close(watcher_fd_);
  if (told && watcher_pid_ > 0) {
    while (::waitpid(watcher_pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
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
