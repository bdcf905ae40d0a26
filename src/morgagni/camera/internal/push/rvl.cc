// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/rvl.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr int kMaxGroups = 10;  // 30 bits: more than any run or difference has.

/// Numbers in groups of three bits, the lowest first; a fourth bit says that more follow.
class GroupReader {
 public:
  explicit GroupReader(std::span<const std::byte> packed) : rest_(packed) {}

  std::optional<std::uint32_t> take() {
    std::uint32_t value = 0;
    for (int i = 0; i < kMaxGroups; ++i) {
      if (num_left_ == 0 && !next_word()) return std::nullopt;
      const std::uint32_t group = word_ >> 28U;
      word_ <<= 4U;
      --num_left_;
      value |= (group & 7U) << (3U * static_cast<unsigned>(i));
      if ((group & 8U) == 0) return value;
    }
    return std::nullopt;
  }

 private:
  bool next_word() {
    if (rest_.size() < sizeof(word_)) return false;
    std::memcpy(&word_, rest_.data(), sizeof(word_));
    rest_ = rest_.subspan(sizeof(word_));
    num_left_ = 8;
    return true;
  }

  std::span<const std::byte> rest_;
  std::uint32_t word_ = 0;
  int num_left_ = 0;
};

tl::unexpected<Error> broken(std::size_t done, std::size_t all) {
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("an RVL picture breaks off after {} of {} pixels", done, all));
}

}  // namespace

Result<void> decode_rvl(std::span<const std::byte> packed, std::span<std::uint16_t> pixels) {
  GroupReader in(packed);
  std::size_t done = 0;
  std::uint16_t last = 0;
  while (done < pixels.size()) {
    const auto num_zeros = in.take();
    if (!num_zeros || *num_zeros > pixels.size() - done) return broken(done, pixels.size());
    std::fill_n(pixels.begin() + static_cast<std::ptrdiff_t>(done), *num_zeros, std::uint16_t{0});
    done += *num_zeros;
    // After zeros up to the end, what follows (a count of 0 from some encoders) is not asked for.
    if (done == pixels.size()) break;
    const auto num_others = in.take();
    if (!num_others || *num_others > pixels.size() - done) return broken(done, pixels.size());
    for (std::uint32_t i = 0; i < *num_others; ++i) {
      const auto folded = in.take();
      if (!folded) return broken(done, pixels.size());
      // 0, 1, 2, 3, ... stand for 0, -1, 1, -2, ...
      const std::uint32_t difference = (*folded >> 1U) ^ (0U - (*folded & 1U));
      last = static_cast<std::uint16_t>(last + difference);
      pixels[done++] = last;
    }
  }
  return {};
}

}  // namespace mor::internal
