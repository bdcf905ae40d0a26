// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/mcap/output_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace mor::internal::mcap {
namespace {

tl::unexpected<Error> failed(const std::filesystem::path& path, int number) {
  return make_error(ErrorCode::kIo, fmt::format("{}: {}", path.string(), std::strerror(number)));
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  const int fd = open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0644);
  if (fd >= 0) return OutputFile(path, fd);
  if (errno == EEXIST) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{}: exists; a recording is never written over", path.string()));
  }
  return failed(path, errno);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)), size_(other.size_) {}

OutputFile::~OutputFile() {
  if (fd_ >= 0) close(fd_);
}

Result<void> OutputFile::append(std::span<const std::byte> bytes) {
  auto rest = bytes;
  while (!rest.empty()) {
    const auto count = ::write(fd_, rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int number = errno;
      if (ftruncate(fd_, static_cast<off_t>(size_)) != 0 ||
          lseek(fd_, static_cast<off_t>(size_), SEEK_SET) < 0) {
        return failed(path_, errno);
      }
      return failed(path_, number);
    }
    rest = rest.subspan(static_cast<std::size_t>(count));
  }
  size_ += bytes.size();
  return {};
}

Result<void> OutputFile::append_and_sync(std::span<const std::byte> bytes) {
  MOR_CHECK(append(bytes));
  return sync();
}

Result<void> OutputFile::sync() {
  if (fdatasync(fd_) != 0) return failed(path_, errno);
  return {};
}

}  // namespace mor::internal::mcap
