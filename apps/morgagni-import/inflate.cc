// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "inflate.h"

#include <algorithm>
#include <functional>

#include <zlib.h>

#include "sandbox.h"

namespace mor::import {

std::uint64_t max_inflated_bytes(std::uint64_t compressed) {
  constexpr std::uint64_t kMaxRatio = 400;
  constexpr std::uint64_t kAlwaysFine = 16U << 20U;
  constexpr std::uint64_t kMost = (2ULL << 30U) + (64ULL << 20U);  // A volume and its head.
  return std::min(kMost, std::max(kAlwaysFine, compressed * kMaxRatio));
}

namespace {

/// Hands what a stream inflates to `take`, piece by piece. @return How many bytes.
Result<std::uint64_t> inflate_pieces(std::span<const std::byte> compressed,
                                     const std::function<void(std::span<const std::byte>)>& take) {
  const auto damaged = make_error(ErrorCode::kIo, "is cut short or damaged");
  z_stream stream{};
  if (::inflateInit2(&stream, -MAX_WBITS) != Z_OK) return damaged;
  const std::uint64_t limit = max_inflated_bytes(compressed.size());
  std::uint64_t num_bytes = 0;
  std::vector<std::byte> piece(std::size_t{1} << 18);
  stream.next_in =
      const_cast<Bytef*>(reinterpret_cast<const Bytef*>(compressed.data()));  // zlib only reads it
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(compressed.size(), 0xffff'ffffU));
  int status = Z_OK;
  while (status == Z_OK && num_bytes <= limit) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    status = ::inflate(&stream, Z_NO_FLUSH);
    const std::size_t got = piece.size() - stream.avail_out;
    take(std::span(piece).first(got));
    num_bytes += got;
  }
  ::inflateEnd(&stream);
  if (num_bytes > limit) {
    return make_error(
        ErrorCode::kInvalidArgument,
        "would inflate to more than " + std::to_string(limit >> 20) + " MiB: it is no picture");
  }
  if (status != Z_STREAM_END) return damaged;
  return num_bytes;
}

}  // namespace

Result<std::vector<std::byte>> inflate_raw(std::span<const std::byte> compressed) {
  // Once to count, so that no more memory is allowed than is needed.
  MOR_TRY(const auto num_bytes, inflate_pieces(compressed, [](std::span<const std::byte>) {}));
  allow_memory(num_bytes);
  std::vector<std::byte> inflated;
  inflated.reserve(num_bytes);
  MOR_CHECK(inflate_pieces(compressed, [&](std::span<const std::byte> piece) {
    inflated.insert(inflated.end(), piece.begin(), piece.end());
  }));
  return inflated;
}

}  // namespace mor::import
