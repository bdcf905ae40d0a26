// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "morgagni/core/result.h"

namespace mor::internal::mcap {

/// A new file that only grows, by whole pieces: a piece that does not fit is taken back.
class OutputFile {
 public:
  /// @errors kInvalidArgument: the file exists; kIo.
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& path);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// @errors kIo: names the file and why (disk full).
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);
  /// The same, and hands the bytes to the disk.
  [[nodiscard]] Result<void> append_and_sync(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> sync();

 private:
  OutputFile(std::filesystem::path path, int fd) : path_(std::move(path)), fd_(fd) {}

  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace mor::internal::mcap
