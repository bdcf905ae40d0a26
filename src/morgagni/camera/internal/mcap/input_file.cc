// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/mcap/input_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

namespace mor::internal::mcap {

Bytes make_bytes(std::size_t size) {
  return {std::unique_ptr<std::byte[]>(new std::byte[size]), size};  // NOLINT: not zeroed
}

Result<InputFile> InputFile::open(const std::filesystem::path& path) {
  // O_NONBLOCK: opening a pipe must not wait for its other end.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    const auto code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return make_error(code, fmt::format("{}: {}", path.string(), std::strerror(errno)));
  }
  struct stat status {};
  InputFile file(path, fd, 0);
  if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    return make_error(ErrorCode::kIo, fmt::format("{}: is no file", path.string()));
  }
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)), size_(other.size_) {}

InputFile::~InputFile() {
  if (fd_ >= 0) close(fd_);
}

Result<Bytes> InputFile::read(std::uint64_t at, std::uint64_t count) const {
  if (at > size_ || count > size_ - at) {
    return make_error(
        ErrorCode::kIo,
        fmt::format("{}: ends at byte {}, {} were expected", name(), size_, at + count));
  }
  auto bytes = make_bytes(count);
  for (std::size_t done = 0; done < count;) {
    const auto got =
        pread(fd_, bytes.data.get() + done, count - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      return make_error(
          ErrorCode::kIo,
          fmt::format("{}: {}", name(), got < 0 ? std::strerror(errno) : "became shorter"));
    }
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace mor::internal::mcap
