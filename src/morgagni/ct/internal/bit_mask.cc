// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/bit_mask.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
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
struct Ball {
  std::map<int, std::vector<BallRow>, std::greater<>> rows;  ///< By half_width.
  int reach_y = 0;
  int reach_z = 0;
};

Ball make_ball(double radius_mm, const Eigen::Vector3d& spacing_mm) {
  Ball ball;
  ball.reach_y = static_cast<int>(radius_mm / spacing_mm.y());
  ball.reach_z = static_cast<int>(radius_mm / spacing_mm.z());
  for (int dz = -ball.reach_z; dz <= ball.reach_z; ++dz) {
    for (int dy = -ball.reach_y; dy <= ball.reach_y; ++dy) {
      const double y_mm = dy * spacing_mm.y();
      const double z_mm = dz * spacing_mm.z();
      const double left_mm2 = radius_mm * radius_mm - y_mm * y_mm - z_mm * z_mm;
      if (left_mm2 < 0.0) continue;
      ball.rows[static_cast<int>(std::sqrt(left_mm2) / spacing_mm.x())].push_back({dy, dz});
    }
  }
  return ball;
}

/// With what a ball reaches along y and z.
VoxelBox grown(VoxelBox box, const Ball& ball, const std::array<int, 3>& size) {
  const std::array<int, 3> reach = {0, ball.reach_y, ball.reach_z};
  for (std::size_t axis = 1; axis < 3; ++axis) {
    box.first[axis] = std::max(0, box.first[axis] - reach[axis]);
    box.end[axis] = std::min(size[axis], box.end[axis] + reach[axis]);
  }
  return box;
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

/// Bytes of 0 or 1 as bits.
Word bits_of(const std::array<std::uint8_t, kWordBits>& bytes) {
  Word bits = 0;
  for (std::size_t first = 0; first < bytes.size(); first += 8) {
    Word eight = 0;
    std::memcpy(&eight, &bytes[first], sizeof(eight));
    // Byte k times 2^(56 - 7 k): its bit comes to stand at 56 + k.
    bits |= (eight * 0x0102040810204080U >> 56U) << first;
  }
  return bits;
}

/// The rows of a dilation that lead through a box; the others stay empty.
BitMask dilated_in(const VoxelBox& box, const BitMask& mask, const Ball& ball) {
  const auto& size = mask.size();
  const Word used = last_word_bits(size[0]);
  BitMask result(size);
  tbb::parallel_for(box.first[2], box.end[2], [&](int z) {
    int width = 0;
    const auto grow_to = [&](int wanted) {
      for (int y = box.first[1]; y < box.end[1]; ++y)
        for (int step = width; step > wanted; --step) grow_row(result.row(y, z));
      width = wanted;
    };
    // What the widest rows reach is grown on along with what the next ones do.
    for (const auto& [half_width, rows] : ball.rows) {
      grow_to(half_width);
      for (const auto& [dy, dz] : rows) {
        const int first = std::max(box.first[1], -dy);
        const int num_rows = std::min(box.end[1], size[1] - dy) - first;
        if (num_rows <= 0 || z + dz < 0 || z + dz >= size[2]) continue;
        const Word* from = mask.row(first + dy, z + dz).data();
        Word* to = result.row(first, z).data();
        for (int i = 0; i < num_rows * mask.words_per_row(); ++i) to[i] |= from[i];
      }
    }
    grow_to(0);
    for (int y = box.first[1]; y < box.end[1]; ++y) result.row(y, z).back() &= used;
  });
  return result;
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

VoxelBox box_of(const BitMask& mask) {
  VoxelBox box = {mask.size(), {0, 0, 0}};
  std::vector<Word> columns(static_cast<std::size_t>(mask.words_per_row()));
  for (int z = 0; z < mask.size()[2]; ++z) {
    for (int y = 0; y < mask.size()[1]; ++y) {
      const auto row = mask.row(y, z);
      if (std::all_of(row.begin(), row.end(), [](Word word) { return word == 0; })) continue;
      for (std::size_t i = 0; i < row.size(); ++i) columns[i] |= row[i];
      box.first[1] = std::min(box.first[1], y);
      box.end[1] = std::max(box.end[1], y + 1);
      box.first[2] = std::min(box.first[2], z);
      box.end[2] = z + 1;
    }
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == 0) continue;
    const int begin = static_cast<int>(i) * kWordBits;
    box.first[0] = std::min(box.first[0], begin + std::countr_zero(columns[i]));
    box.end[0] = begin + kWordBits - std::countl_zero(columns[i]);
  }
  return box;
}

BitMask threshold(const Volume& volume, double low_hu, double high_hu) {
  const auto low = static_cast<std::int16_t>(std::clamp(std::ceil(low_hu), -32768.0, 32767.0));
  const auto high = static_cast<std::int16_t>(std::clamp(std::floor(high_hu), -32768.0, 32767.0));
  BitMask mask(volume.size);
  tbb::parallel_for(0, volume.size[2], [&](int z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      const std::int16_t* hu = volume.hu.data() + volume.index(0, y, z);
      const auto row = mask.row(y, z);
      for (int begin = 0; begin < volume.size[0]; begin += kWordBits) {
        const int num = std::min(kWordBits, volume.size[0] - begin);
        std::array<std::uint8_t, kWordBits> is_inside{};
        for (int i = 0; i < num; ++i)
          is_inside[static_cast<std::size_t>(i)] =
              (hu[begin + i] >= low ? 1 : 0) & (hu[begin + i] <= high ? 1 : 0);
        row[static_cast<std::size_t>(begin / kWordBits)] = bits_of(is_inside);
      }
    }
  });
  return mask;
}

BitMask dilated(const BitMask& mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  const Ball ball = make_ball(radius_mm, spacing_mm);
  return dilated_in(grown(box_of(mask), ball, mask.size()), mask, ball);
}

BitMask eroded(BitMask mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  BitMask outside = mask;
  outside.invert();
  mask.subtract(dilated_in(box_of(mask), outside, make_ball(radius_mm, spacing_mm)));
  return mask;
}

BitMask closed(const BitMask& mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  if (radius_mm <= 0.0) return mask;
  return eroded(dilated(mask, radius_mm, spacing_mm), radius_mm, spacing_mm);
}

BitMask opened(BitMask mask, double radius_mm, const Eigen::Vector3d& spacing_mm) {
  return dilated(eroded(std::move(mask), radius_mm, spacing_mm), radius_mm, spacing_mm);
}

}  // namespace mor::internal
