// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/folder_lock.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/file.h>
#include <unistd.h>

namespace mor {

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder,
                                    Kind kind,
                                    std::string_view busy) {
  FolderLock lock(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.fd_ < 0) {
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: cannot be opened: {}", folder.string(), strerror(errno)));
  }
  const int operation = (kind == Kind::kShared ? LOCK_SH : LOCK_EX) | LOCK_NB;
  if (flock(lock.fd_, operation) == 0) return lock;
  if (errno == EWOULDBLOCK) return make_error(ErrorCode::kInvalidArgument, std::string(busy));
  return make_error(ErrorCode::kIo,
                    fmt::format("{}: cannot be locked: {}", folder.string(), strerror(errno)));
}

Result<FolderLock> FolderLock::make_and_take(const std::filesystem::path& folder,
                                             Kind kind,
                                             std::string_view busy) {
  std::error_code status;
  std::filesystem::create_directories(folder, status);
  if (!status) return take(folder, kind, busy);
  return make_error(ErrorCode::kIo,
                    fmt::format("{}: cannot be made: {}", folder.string(), status.message()));
}

FolderLock::FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FolderLock::~FolderLock() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace mor
