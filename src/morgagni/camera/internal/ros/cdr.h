// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/camera/internal/byte_io.h"

namespace mor::internal::ros {

/// CDR as ROS 2 sends it: a head of four bytes, then little-endian values, each aligned to its
/// size.
inline constexpr std::size_t kCdrHeadBytes = 4;

class CdrWriter {
 public:
  CdrWriter() { out_.put(std::uint32_t{0x00000100}); }  // Bytes 00 01 00 00: CDR, little-endian.

  template <PlainNumber T>
  void put(T value) {
    out_.align(sizeof(T), kCdrHeadBytes);
    out_.put(value);
  }
  void put_string(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    out_.put_text(text);
    out_.put(std::uint8_t{0});
  }
  void put_size(std::size_t count) { put(static_cast<std::uint32_t>(count)); }
  void put_bytes(std::span<const std::byte> bytes) { out_.put_bytes(bytes); }
  [[nodiscard]] std::vector<std::byte> take() { return out_.take(); }

 private:
  ByteWriter out_;
};

class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> bytes) : in_(bytes) {
    const auto head = in_.take<std::uint32_t>();
    is_little_endian_ = (head & 0xFFFFU) == 0x0100U;
  }

  [[nodiscard]] bool ok() const { return in_.ok() && is_little_endian_; }

  template <PlainNumber T>
  T take() {
    in_.align(sizeof(T), kCdrHeadBytes);
    return in_.take<T>();
  }
  std::string_view take_string() {
    const auto text = in_.take_text(take<std::uint32_t>());
    return text.empty() ? text : text.substr(0, text.size() - 1);
  }
  std::span<const std::byte> take_bytes(std::uint64_t count) { return in_.take_bytes(count); }

 private:
  ByteReader in_;
  bool is_little_endian_ = false;
};

}  // namespace mor::internal::ros
