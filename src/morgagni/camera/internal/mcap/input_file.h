// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "morgagni/core/result.h"

namespace mor::internal::mcap {

/// Bytes that were read, not zeroed before.
struct Bytes {
  std::unique_ptr<std::byte[]> data;  // NOLINT(modernize-avoid-c-arrays)
  std::size_t size = 0;

  [[nodiscard]] std::span<const std::byte> span() const { return {data.get(), size}; }
};

[[nodiscard]] Bytes make_bytes(std::size_t size);

/// A file read here and there.
class InputFile {
 public:
  /// @errors kNotFound, kIo.
  [[nodiscard]] static Result<InputFile> open(const std::filesystem::path& path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  ~InputFile();

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] std::string name() const { return path_.string(); }

  /// @errors kIo: there are not so many bytes.
  [[nodiscard]] Result<Bytes> read(std::uint64_t at, std::uint64_t count) const;

 private:
  InputFile(std::filesystem::path path, int fd, std::uint64_t size)
      : path_(std::move(path)), fd_(fd), size_(size) {}

  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace mor::internal::mcap
