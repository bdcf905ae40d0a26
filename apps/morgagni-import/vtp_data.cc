// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtp_data.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>

#include <zlib.h>

#include "inflate.h"

namespace mor::import {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint64_t kMostBlocks = 1'000'000;

std::uint64_t head_at(Bytes bytes, const VtpCoding& coding) {
  const std::size_t size = coding.wide_heads ? 8 : 4;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const auto byte = std::to_integer<std::uint64_t>(bytes[coding.big_endian ? i : size - 1 - i]);
    value = value << 8 | byte;
  }
  return value;
}

bool inflate_into(Bytes compressed, std::span<std::byte> place) {
  uLongf num_bytes = place.size();
  return ::uncompress(reinterpret_cast<Bytef*>(place.data()),
                      &num_bytes,
                      reinterpret_cast<const Bytef*>(compressed.data()),
                      compressed.size()) == Z_OK &&
         num_bytes == place.size();
}

/// The head of compressed data: how large each block is, packed and unpacked.
struct Blocks {
  std::vector<std::uint64_t> packed;
  std::uint64_t full_bytes = 0;
  std::uint64_t last_bytes = 0;
  std::size_t head_bytes = 0;

  [[nodiscard]] std::uint64_t num_bytes() const {
    if (packed.empty()) return 0;
    return (packed.size() - 1) * full_bytes + (last_bytes > 0 ? last_bytes : full_bytes);
  }
};

/// Of a head's numbers, asked for one by one.
template <class NumberAt>
std::optional<Blocks> blocks_of(const NumberAt& number_at, std::size_t at_most, std::size_t size) {
  constexpr std::uint64_t kMostBlockBytes = std::uint64_t{1} << 32;
  const auto num_blocks = number_at(0);
  const auto full = number_at(1);
  const auto last = number_at(2);
  if (!num_blocks || !full || !last || *num_blocks > kMostBlocks) return std::nullopt;
  Blocks blocks;
  blocks.full_bytes = *full;
  blocks.last_bytes = *last;
  // A block may be larger than all that is in it; with these limits no product overflows.
  if (*full > kMostBlockBytes || *last > *full) return std::nullopt;
  for (std::uint64_t i = 0; i < *num_blocks; ++i) {
    const auto packed = number_at(3 + i);
    if (!packed) return std::nullopt;
    blocks.packed.push_back(*packed);
  }
  blocks.head_bytes = static_cast<std::size_t>(3 + *num_blocks) * size;
  if (blocks.num_bytes() > at_most) return std::nullopt;
  return blocks;
}

std::optional<std::vector<std::byte>> unpacked(const Blocks& blocks, Bytes bytes) {
  std::uint64_t packed_bytes = 0;
  for (const auto packed : blocks.packed) {
    if (packed > bytes.size() - packed_bytes) return std::nullopt;
    packed_bytes += packed;
  }
  if (blocks.num_bytes() > max_inflated_bytes(packed_bytes)) return std::nullopt;
  std::vector<std::byte> result(blocks.num_bytes());
  std::size_t from = 0;
  std::size_t to = 0;
  for (const auto packed : blocks.packed) {
    const std::size_t num_bytes = std::min<std::size_t>(blocks.full_bytes, result.size() - to);
    if (!inflate_into(bytes.subspan(from, packed), std::span(result).subspan(to, num_bytes)))
      return std::nullopt;
    from += packed;
    to += num_bytes;
  }
  return result;
}

int base64_value(char letter) {
  if (letter >= 'A' && letter <= 'Z') return letter - 'A';
  if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
  if (letter >= '0' && letter <= '9') return letter - '0' + 52;
  if (letter == '+') return 62;
  if (letter == '/') return 63;
  return -1;
}

/// As many bytes as are wanted, from fours of letters; `text` begins behind them then.
std::optional<std::vector<std::byte>> decoded(std::string_view& text, std::size_t num_bytes) {
  if ((num_bytes + 2) / 3 > text.size() / 4) return std::nullopt;
  std::vector<std::byte> bytes;
  bytes.reserve(num_bytes + 2);
  while (bytes.size() < num_bytes) {
    if (text.size() < 4) return std::nullopt;
    std::uint32_t four = 0;
    int num_letters = 0;
    for (const char letter : text.substr(0, 4)) {
      const int value = base64_value(letter);
      if (value < 0 && letter != '=') return std::nullopt;
      if (value >= 0) ++num_letters;
      four = four << 6 | static_cast<std::uint32_t>(std::max(value, 0));
    }
    for (int i = 0; i + 1 < num_letters; ++i)
      bytes.push_back(static_cast<std::byte>(four >> (16 - 8 * i) & 0xff));
    text.remove_prefix(4);
  }
  bytes.resize(num_bytes);
  return bytes;
}

template <class Number>
std::vector<double> numbers_as(Bytes bytes, bool big_endian) {
  std::vector<double> numbers(bytes.size() / sizeof(Number));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::array<std::byte, sizeof(Number)> word;
    std::memcpy(word.data(), bytes.data() + i * sizeof(Number), sizeof(Number));
    if (big_endian) std::reverse(word.begin(), word.end());
    Number number;
    std::memcpy(&number, word.data(), sizeof(Number));
    numbers[i] = static_cast<double>(number);
  }
  return numbers;
}

}  // namespace

std::optional<std::vector<std::byte>> vtp_raw(Bytes bytes,
                                              const VtpCoding& coding,
                                              std::size_t at_most) {
  const std::size_t size = coding.wide_heads ? 8 : 4;
  if (!coding.compressed) {
    if (bytes.size() < size) return std::nullopt;
    const std::uint64_t num_bytes = head_at(bytes, coding);
    if (num_bytes > at_most || num_bytes > bytes.size() - size) return std::nullopt;
    const Bytes data = bytes.subspan(size, num_bytes);
    return std::vector<std::byte>(data.begin(), data.end());
  }
  const auto number_at = [&](std::uint64_t index) -> std::optional<std::uint64_t> {
    if ((index + 1) * size > bytes.size()) return std::nullopt;
    return head_at(bytes.subspan(index * size), coding);
  };
  const auto blocks = blocks_of(number_at, at_most, size);
  if (!blocks) return std::nullopt;
  return unpacked(*blocks, bytes.subspan(blocks->head_bytes));
}

std::optional<std::vector<std::byte>> vtp_base64(std::string_view text,
                                                 const VtpCoding& coding,
                                                 std::size_t at_most) {
  const std::size_t size = coding.wide_heads ? 8 : 4;
  if (!coding.compressed) {
    // Head and data are one run of letters.
    std::string_view head_text = text;
    const auto head = decoded(head_text, size);
    if (!head) return std::nullopt;
    const std::uint64_t num_bytes = head_at(*head, coding);
    if (num_bytes > at_most) return std::nullopt;
    auto all = decoded(text, size + num_bytes);
    if (all) all->erase(all->begin(), all->begin() + static_cast<std::ptrdiff_t>(size));
    return all;
  }
  // The head is a run of its own.
  std::string_view first = text;
  const auto count = decoded(first, size);
  if (!count || head_at(*count, coding) > kMostBlocks) return std::nullopt;
  const auto head = decoded(text, (3 + head_at(*count, coding)) * size);
  if (!head) return std::nullopt;
  const auto number_at = [&](std::uint64_t index) -> std::optional<std::uint64_t> {
    if ((index + 1) * size > head->size()) return std::nullopt;
    return head_at(Bytes(*head).subspan(index * size), coding);
  };
  const auto blocks = blocks_of(number_at, at_most, size);
  if (!blocks) return std::nullopt;
  std::uint64_t packed_bytes = 0;
  for (const auto packed : blocks->packed) {
    if (packed > text.size()) return std::nullopt;
    packed_bytes += packed;
  }
  const auto packed = decoded(text, packed_bytes);
  return packed ? unpacked(*blocks, *packed) : std::nullopt;
}

std::size_t vtp_type_bytes(std::string_view type) {
  if (type == "Int8" || type == "UInt8") return 1;
  if (type == "Int16" || type == "UInt16") return 2;
  if (type == "Int32" || type == "UInt32" || type == "Float32") return 4;
  if (type == "Int64" || type == "UInt64" || type == "Float64") return 8;
  return 0;
}

std::optional<std::vector<double>> vtp_numbers(Bytes bytes,
                                               std::string_view type,
                                               bool big_endian) {
  const std::size_t size = vtp_type_bytes(type);
  if (size == 0 || bytes.size() % size != 0) return std::nullopt;
  if (type == "Int8") return numbers_as<std::int8_t>(bytes, big_endian);
  if (type == "UInt8") return numbers_as<std::uint8_t>(bytes, big_endian);
  if (type == "Int16") return numbers_as<std::int16_t>(bytes, big_endian);
  if (type == "UInt16") return numbers_as<std::uint16_t>(bytes, big_endian);
  if (type == "Int32") return numbers_as<std::int32_t>(bytes, big_endian);
  if (type == "UInt32") return numbers_as<std::uint32_t>(bytes, big_endian);
  if (type == "Int64") return numbers_as<std::int64_t>(bytes, big_endian);
  if (type == "UInt64") return numbers_as<std::uint64_t>(bytes, big_endian);
  if (type == "Float32") return numbers_as<float>(bytes, big_endian);
  return numbers_as<double>(bytes, big_endian);
}

std::optional<std::vector<double>> vtp_ascii(std::string_view text, std::size_t at_most) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<double> numbers;
  while (true) {
    const auto begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return numbers;
    text.remove_prefix(begin);
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || numbers.size() == at_most) return std::nullopt;
    numbers.push_back(number);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (!text.empty() && kBlanks.find(text.front()) == std::string_view::npos) return std::nullopt;
  }
}

}  // namespace mor::import
