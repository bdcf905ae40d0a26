// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "inflate.h"

#include <algorithm>

#include <zlib.h>

#include "sandbox.h"

namespace mor::import {

std::uint64_t max_inflated_bytes(std::uint64_t compressed) {
  constexpr std::uint64_t kMaxRatio = 400;
  constexpr std::uint64_t kAlwaysFine = 16U << 20U;
  constexpr std::uint64_t kMost = 4ULL << 30U;
  return std::min(kMost, std::max(kAlwaysFine, compressed * kMaxRatio));
}

Result<std::vector<std::byte>> inflate_raw(std::span<const std::byte> compressed) {
  const auto damaged = make_error(ErrorCode::kIo, "is cut short or damaged");
  z_stream stream{};
  if (::inflateInit2(&stream, -MAX_WBITS) != Z_OK) return damaged;
  const std::uint64_t limit = max_inflated_bytes(compressed.size());
  constexpr std::uint64_t kEnoughForFrames = 512ULL << 20U;
  allow_memory(std::min(limit, kEnoughForFrames));
  std::vector<std::byte> inflated;
  std::vector<std::byte> piece(std::size_t{1} << 18);
  stream.next_in =
      const_cast<Bytef*>(reinterpret_cast<const Bytef*>(compressed.data()));  // zlib only reads it
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(compressed.size(), 0xffff'ffffU));
  int status = Z_OK;
  while (status == Z_OK && inflated.size() <= limit) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    status = ::inflate(&stream, Z_NO_FLUSH);
    inflated.insert(
        inflated.end(), piece.begin(), piece.end() - static_cast<std::ptrdiff_t>(stream.avail_out));
  }
  ::inflateEnd(&stream);
  if (inflated.size() > limit) {
    return make_error(
        ErrorCode::kInvalidArgument,
        "would inflate to more than " + std::to_string(limit >> 20) + " MiB: it is no picture");
  }
  if (status != Z_STREAM_END) return damaged;
  return inflated;
}

}  // namespace mor::import
