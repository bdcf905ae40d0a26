// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "morgagni/core/result.h"

namespace mor::internal::mcap {

struct ChannelInfo {
  std::string topic;
  std::string encoding;  ///< Of its messages: "cdr", "json", ...
};

/// A message in the file.
struct MessageRef {
  std::uint64_t time_ns = 0;
  std::uint64_t offset = 0;  ///< In the unpacked chunk.
  std::uint32_t chunk = 0;
  std::uint16_t channel = 0;
};

/// An MCAP file to read from. It is looked through by its records' heads, not by its summary, so a
/// file that ends in the middle (the program was killed, the disk full) gives all up to there.
///
/// Every length is checked against the file before it is believed; a chunk may unpack to 256 MiB at
/// most, and is checked against its CRC when it is unpacked.
class Reader {
 public:
  /// @errors kNotFound, kIo, kInvalidArgument (no MCAP, or one that lies: names the byte).
  [[nodiscard]] static Result<Reader> open(const std::filesystem::path& path);
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();

  [[nodiscard]] const std::map<std::uint16_t, ChannelInfo>& channels() const;
  /// In the file's order.
  [[nodiscard]] const std::vector<MessageRef>& messages() const;
  /// False: the file has no end, what follows the last whole chunk is lost.
  [[nodiscard]] bool is_complete() const;

  /// The message's own bytes, valid until the next call. Neighbours in time are cheap.
  /// @errors kInvalidArgument: the chunk is damaged, or the index lies.
  [[nodiscard]] Result<std::span<const std::byte>> read(const MessageRef& message);

  /// The first attachment of that name. @errors kNotFound, kInvalidArgument (damaged).
  [[nodiscard]] Result<std::vector<std::byte>> attachment(const std::string& name);

 private:
  struct Impl;
  explicit Reader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor::internal::mcap
