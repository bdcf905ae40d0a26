// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/bit_mask.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include <tbb/parallel_for.h>

namespace mor::internal {
namespace {

using Word = BitMask::Word;
constexpr int kWordBits = BitMask::kWordBits;

/// The bits of the last word that lie within the row.
Word last_word_bits(int size_x) {
  const int used = (size_x - 1) % kWordBits + 1;
  return used == kWordBits ? ~Word{0} : (Word{1} << used) - 1;
}

/// A ball as rows: at (dy, dz) it reaches `half_width` voxels to either side.
struct BallRow {
  int dy = 0;
  int dz = 0;
};
using Ball = std::map<int, std::vector<BallRow>>;  // by half_width

Ball make_ball(double radius_mm, const Eigen::Vector3d& spacing_mm) {
  Ball ball;
  const int reach_y = static_cast<int>(radius_mm / spacing_mm.y());
  const int reach_z = static_cast<int>(radius_mm / spacing_mm.z());
  for (int dz = -reach_z; dz <= reach_z; ++dz) {
    for (int dy = -reach_y; dy <= reach_y; ++dy) {
      const double y_mm = dy * spacing_mm.y();
      const double z_mm = dz * spacing_mm.z();
      const double left_mm2 = radius_mm * radius_mm - y_mm * y_mm - z_mm * z_mm;
      if (left_mm2 < 0.0) continue;
      ball[static_cast<int>(std::sqrt(left_mm2) / spacing_mm.x())].push_back({dy, dz});
    }
  }
  return ball;
}

/// `row` grown by one voxel to either side, in place.
void grow_row(std::span<Word> row) {
  Word before = 0;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const Word here = row[i];
    const Word after = i + 1 < row.size() ? row[i + 1] : 0;
    row[i] = here | here << 1 | here >> 1 | before >> (kWordBits - 1) | after << (kWordBits - 1);
    before = here;
  }
}

}  // namespace

BitMask::BitMask(const std::array<int, 3>& size)
    : size_(size),
      words_per_row_((size[0] + kWordBits - 1) / kWordBits),
      words_(static_cast<std::size_t>(words_per_row_) * static_cast<std::size_t>(size[1]) *
             static_cast<std::size_t>(size[2])) {}

void BitMask::set_run(int y, int z, int begin, int end) {
  const auto words = row(y, z);
  for (int x = begin; x < end;) {
    const int offset = x % kWordBits;
    const int count = std::min(end - x, kWordBits - offset);
    const Word ones = count == kWordBits ? ~Word{0} : (Word{1} << count) - 1;
    words[static_cast<std::size_t>(x / kWordBits)] |= ones << offset;
    x += count;
  }
}

std::size_t BitMask::count() const {
  std::size_t sum = 0;
  for (const Word word : words_) sum += static_cast<std::size_t>(std::popcount(word));
  return sum;
}

void BitMask::invert() {
  for (Word& word : words_) word = ~word;
  const Word used = last_word_bits(size_[0]);
  const auto step = static_cast<std::size_t>(words_per_row_);
  for (std::size_t i = step - 1; i < words_.size(); i += step) words_[i] &= used;
}

BitMask& BitMask::operator&=(const BitMask& other) {
  for (std::size_t i = 0; i < words_.size(); ++i) words_[i] &= other.words_[i];
  return *this;
}

BitMask& BitMask::operator|=(const BitMask& other) {
  for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= other.words_[i];
  return *this;
}

void BitMask::subtract(const BitMask& other) {
  for (std::size_t i = 0; i < words_.size(); ++i) words_[i] &= ~other.words_[i];
}

BitMask threshold(const Volume& volume, double low_hu, double high_hu) {
  const auto low = static_cast<int>(std::clamp(std::ceil(low_hu), -32768.0, 32767.0));
  const auto high = static_cast<int>(std::clamp(std::floor(high_hu), -32768.0, 32767.0));
  BitMask mask(volume.size);
  tbb::parallel_for(0, volume.size[2], [&](int z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      const std::int16_t* hu = volume.hu.data() + volume.index(0, y, z);
      const auto row = mask.row(y, z);
      for (int x = 0; x < volume.size[0]; ++x) {
        const Word inside = hu[x] >= low && hu[x] <= high ? 1 : 0;
        row[static_cast<std::size_t>(x / kWordBits)] |= inside << (x % kWordBits);
      }
    }
  });
  return mask;
}

BitMask dilated(const BitMask& mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  const Ball ball = make_ball(radius_mm, spacing_mm);
  const auto [size_x, size_y, size_z] = mask.size();
  BitMask result(mask.size());
  BitMask wide = mask;
  int width = 0;
  for (const auto& [half_width, rows] : ball) {
    const int num_steps = half_width - std::exchange(width, half_width);
    tbb::parallel_for(0, size_z, [&](int z) {
      for (int y = 0; y < size_y; ++y)
        for (int step = 0; step < num_steps; ++step) grow_row(wide.row(y, z));
    });
    tbb::parallel_for(0, size_z, [&](int z) {
      for (const auto& [dy, dz] : rows) {
        if (z + dz < 0 || z + dz >= size_z) continue;
        for (int y = std::max(0, -dy); y < std::min(size_y, size_y - dy); ++y) {
          const auto from = std::as_const(wide).row(y + dy, z + dz);
          const auto to = result.row(y, z);
          for (std::size_t i = 0; i < to.size(); ++i) to[i] |= from[i];
        }
      }
    });
  }
  const Word used = last_word_bits(size_x);
  for (int z = 0; z < size_z; ++z)
    for (int y = 0; y < size_y; ++y) result.row(y, z).back() &= used;
  return result;
}

BitMask eroded(BitMask mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  mask.invert();
  BitMask result = dilated(mask, radius_mm, spacing_mm);
  result.invert();
  return result;
}

BitMask closed(const BitMask& mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  if (radius_mm <= 0.0) return mask;
  return eroded(dilated(mask, radius_mm, spacing_mm), radius_mm, spacing_mm);
}

BitMask opened(BitMask mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  return dilated(eroded(std::move(mask), radius_mm, spacing_mm), radius_mm, spacing_mm);
}

}  // namespace mor::internal
