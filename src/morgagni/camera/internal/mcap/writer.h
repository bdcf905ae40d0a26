// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "morgagni/core/result.h"

namespace mor::internal::mcap {

using TextPairs = std::vector<std::pair<std::string, std::string>>;

struct Attachment {
  std::string name;
  std::string media_type;
  std::span<const std::byte> data;
};

/// Writes an MCAP file from front to back: messages gather in a chunk, which end_chunk() packs
/// (zstd) and puts on disk with its index and CRC. What is on disk at any moment can be read;
/// finish() adds the summary, which lets a reader seek without looking through the file.
class Writer {
 public:
  /// @errors kInvalidArgument: the file exists; kIo.
  [[nodiscard]] static Result<Writer> create(const std::filesystem::path& path,
                                             std::string_view profile);
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;
  /// Closes the file as it is.
  ~Writer();

  /// Before the first message of the channel. Channels count from 1. @errors kIo.
  [[nodiscard]] Result<std::uint16_t> add_channel(std::string_view topic,
                                                  std::string_view schema_name,
                                                  std::string_view schema_text);
  [[nodiscard]] Result<void> add_attachment(const Attachment& attachment, std::uint64_t time_ns);
  [[nodiscard]] Result<void> add_metadata(std::string_view name, const TextPairs& pairs);

  /// Into the open chunk.
  void add_message(std::uint16_t channel,
                   std::uint64_t time_ns,
                   std::span<const std::byte> message);

  /// Bytes of the open chunk, not packed.
  [[nodiscard]] std::size_t open_bytes() const;
  /// Bytes on disk.
  [[nodiscard]] std::uint64_t file_bytes() const;

  /// @errors kIo: nothing of the chunk is on disk then.
  [[nodiscard]] Result<void> end_chunk();
  /// Forgets the open chunk.
  void drop_chunk();
  /// Ends the open chunk and writes the summary. @errors kIo.
  [[nodiscard]] Result<void> finish();

 private:
  struct Impl;
  explicit Writer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor::internal::mcap
