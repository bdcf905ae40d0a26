// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "rle_pixels.h"

#include "byte_order.h"

namespace mor::import {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kHeaderBytes = 64;

/// Unpacks PackBits into every `step`th byte. False: too few bytes, or more than fit.
bool unpack(Bytes packed, std::byte* out, std::size_t count, std::size_t step) {
  std::size_t done = 0;
  std::size_t at = 0;
  while (done < count) {
    if (at + 1 >= packed.size()) return false;
    const auto control = std::to_integer<unsigned>(packed[at++]);
    if (control == 128) continue;
    const bool repeats = control > 128;
    const std::size_t length = repeats ? 257 - control : control + 1;
    const std::size_t needed = repeats ? 1 : length;
    if (length > count - done || needed > packed.size() - at) return false;
    for (std::size_t i = 0; i < length; ++i) out[step * done++] = packed[repeats ? at : at + i];
    at += needed;
  }
  return true;
}

}  // namespace

std::optional<std::vector<std::byte>> decode_rle(Bytes frame,
                                                 std::size_t num_pixels,
                                                 std::size_t bytes_per_pixel) {
  if (frame.size() < kHeaderBytes || little_uint32(frame) != bytes_per_pixel) return {};
  std::vector<std::byte> pixels(num_pixels * bytes_per_pixel);
  for (std::size_t segment = 0; segment < bytes_per_pixel; ++segment) {
    const bool is_last = segment + 1 == bytes_per_pixel;
    const std::size_t begin = little_uint32(frame.subspan(4 * (segment + 1)));
    const std::size_t end =
        is_last ? frame.size() : little_uint32(frame.subspan(4 * (segment + 2)));
    if (begin < kHeaderBytes || begin > end || end > frame.size()) return {};
    // The most significant byte comes first.
    std::byte* const out = pixels.data() + (bytes_per_pixel - 1 - segment);
    if (!unpack(frame.subspan(begin, end - begin), out, num_pixels, bytes_per_pixel)) return {};
  }
  return pixels;
}

}  // namespace mor::import
