// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/files.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>

#include <fcntl.h>
#include <openssl/evp.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace mor {
namespace {

namespace fs = std::filesystem;

Result<std::ifstream> open_for_reading(const fs::path& path) {
  std::error_code status;
  if (!fs::exists(path, status)) {
    return make_error(ErrorCode::kNotFound, fmt::format("{}: no such file", path.string()));
  }
  if (!fs::is_regular_file(path, status)) {
    return make_error(ErrorCode::kIo, fmt::format("{}: not a file", path.string()));
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) return make_error(ErrorCode::kIo, fmt::format("{}: cannot be read", path.string()));
  return in;
}

template <class Container>
Result<Container> read_all(const fs::path& path, std::uintmax_t max_bytes) {
  MOR_TRY(auto in, open_for_reading(path));
  std::error_code status;
  const auto size = fs::file_size(path, status);
  if (status)
    return make_error(ErrorCode::kIo, fmt::format("{}: {}", path.string(), status.message()));
  if (size > max_bytes) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("{} has {} bytes, the limit is {}", path.string(), size, max_bytes));
  }
  Container bytes(size, typename Container::value_type{});
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(in.gcount()) != size) {
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: could not be read to its end", path.string()));
  }
  return bytes;
}

/// Closes the descriptor, and removes the file unless it was renamed into place.
class PendingFile {
 public:
  explicit PendingFile(fs::path path)
      : path_(std::move(path)),
        fd_(open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0644)) {}
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile() {
    if (fd_ >= 0) close(fd_);
    if (!path_.empty()) unlink(path_.c_str());
  }

  bool write_and_sync(std::span<const std::byte> bytes) {
    while (fd_ >= 0 && !bytes.empty()) {
      const auto count = ::write(fd_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return fd_ >= 0 && fsync(fd_) == 0;
  }

  bool rename_to(const fs::path& target) {
    if (std::rename(path_.c_str(), target.c_str()) != 0) return false;
    path_.clear();
    return true;
  }

 private:
  fs::path path_;
  int fd_;
};

using DigestContext = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

DigestContext begin_sha256() {
  DigestContext context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  return context;
}

std::string finish_sha256(const DigestContext& context) {
  std::array<unsigned char, 32> digest{};
  EVP_DigestFinal_ex(context.get(), digest.data(), nullptr);
  std::string hex;
  for (const auto byte : digest) hex += fmt::format("{:02x}", byte);
  return hex;
}

}  // namespace

Result<std::vector<std::byte>> read_file(const fs::path& path, std::uintmax_t max_bytes) {
  return read_all<std::vector<std::byte>>(path, max_bytes);
}

Result<std::string> read_text_file(const fs::path& path, std::uintmax_t max_bytes) {
  return read_all<std::string>(path, max_bytes);
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  PendingFile pending(path.string() + fmt::format(".{}.part", getpid()));
  if (!pending.write_and_sync(bytes) || !pending.rename_to(path)) {
    return make_error(
        ErrorCode::kIo,
        fmt::format("{}: could not be written: {}", path.string(), std::strerror(errno)));
  }
  return {};
}

Result<void> write_file(const fs::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text)));
}

std::string sha256_hex(std::span<const std::byte> bytes) {
  const auto context = begin_sha256();
  EVP_DigestUpdate(context.get(), bytes.data(), bytes.size());
  return finish_sha256(context);
}

Result<std::string> sha256_hex_of_file(const fs::path& path) {
  MOR_TRY(auto in, open_for_reading(path));
  const auto context = begin_sha256();
  std::vector<char> buffer(1U << 20U);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || in.gcount() > 0) {
    EVP_DigestUpdate(context.get(), buffer.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad())
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: could not be read to its end", path.string()));
  return finish_sha256(context);
}

}  // namespace mor
