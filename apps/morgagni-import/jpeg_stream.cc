// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "jpeg_stream.h"

#include <algorithm>

#include "byte_order.h"

namespace mor::import {
namespace {

using Bytes = std::span<const std::byte>;

constexpr unsigned kStart = 0xD8;
constexpr unsigned kScan = 0xDA;
constexpr unsigned kHuffmanTables = 0xC4;
constexpr unsigned kArithmeticTables = 0xCC;
constexpr unsigned kQuantizationTables = 0xDB;
constexpr unsigned kRestartInterval = 0xDD;
constexpr unsigned kExtension = 0xC8;
constexpr unsigned kComment = 0xFE;

bool is_frame(unsigned marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != kHuffmanTables && marker != kExtension &&
         marker != kArithmeticTables;
}

/// What a head may hold besides: all others stand without a length, or have no place in it.
bool is_table(unsigned marker) {
  return marker == kHuffmanTables || marker == kArithmeticTables || marker == kQuantizationTables ||
         marker == kRestartInterval;
}

bool is_left_out(unsigned marker) {
  return (marker >= 0xE0 && marker <= 0xEF) || marker == kComment;
}

/// @param segment  After its marker: length, bits, rows, columns, number of components.
bool is_grey_picture(Bytes segment, int columns, int rows) {
  if (segment.size() < 8) return false;
  const auto bits = std::to_integer<unsigned>(segment[2]);
  return bits >= 2 && bits <= 16 && big_uint16(segment.subspan(3)) == rows &&
         big_uint16(segment.subspan(5)) == columns && segment[7] == std::byte{1};
}

}  // namespace

std::optional<std::vector<std::byte>> checked_jpeg(Bytes stream, int columns, int rows) {
  const auto marker_at = [&](std::size_t at) { return std::to_integer<unsigned>(stream[at + 1]); };
  if (stream.size() < 2 || stream[0] != std::byte{0xFF} || marker_at(0) != kStart) return {};
  std::vector<std::byte> kept(stream.begin(), stream.begin() + 2);
  bool has_frame = false;
  for (std::size_t at = 2; at + 4 <= stream.size();) {
    if (stream[at] != std::byte{0xFF}) return {};
    const unsigned marker = marker_at(at);
    if (marker == 0xFF) {  // Filled up.
      ++at;
      continue;
    }
    if (!is_frame(marker) && !is_table(marker) && !is_left_out(marker) && marker != kScan)
      return {};
    const std::size_t length = big_uint16(stream.subspan(at + 2));
    if (length < 2 || length > stream.size() - at - 2) return {};
    if (is_frame(marker)) {
      if (has_frame || !is_grey_picture(stream.subspan(at + 2, length), columns, rows)) return {};
      has_frame = true;
    }
    if (marker == kScan) {
      if (!has_frame) return {};
      kept.insert(kept.end(), stream.begin() + static_cast<std::ptrdiff_t>(at), stream.end());
      return kept;
    }
    const Bytes segment = stream.subspan(at, 2 + length);
    if (!is_left_out(marker)) kept.insert(kept.end(), segment.begin(), segment.end());
    at += segment.size();
  }
  return {};
}

}  // namespace mor::import
