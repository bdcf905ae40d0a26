// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/huge_pages.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// One bit a voxel, 64 voxels of a row in a word: morphology works on whole words, so that a
/// closing of a full-size CT takes a fraction of a second. Bits beyond a row's end stay zero.
class BitMask {
 public:
  using Word = std::uint64_t;
  static constexpr int kWordBits = 64;

  BitMask() = default;
  explicit BitMask(const std::array<int, 3>& size);

  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }
  [[nodiscard]] int words_per_row() const { return words_per_row_; }
  [[nodiscard]] std::span<Word> row(int y, int z) {
    return {words_.data() + row_start(y, z), static_cast<std::size_t>(words_per_row_)};
  }
  [[nodiscard]] std::span<const Word> row(int y, int z) const {
    return {words_.data() + row_start(y, z), static_cast<std::size_t>(words_per_row_)};
  }
  [[nodiscard]] bool test(int x, int y, int z) const {
    return (row(y, z)[static_cast<std::size_t>(x / kWordBits)] >> (x % kWordBits) & 1U) != 0;
  }
  /// Sets the voxels [begin, end) of a row.
  void set_run(int y, int z, int begin, int end);
  [[nodiscard]] std::size_t count() const;

  void invert();
  BitMask& operator&=(const BitMask& other);
  BitMask& operator|=(const BitMask& other);
  /// Keeps what `other` has not.
  void subtract(const BitMask& other);
  bool operator==(const BitMask&) const = default;

 private:
  [[nodiscard]] std::size_t row_start(int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(y)) *
           static_cast<std::size_t>(words_per_row_);
  }

  std::array<int, 3> size_{};
  int words_per_row_ = 0;
  std::vector<Word, HugePages<Word>> words_;
};

/// Calls `visit` with each voxel of a slice that is set.
template <class Visit>
void for_each_voxel_in_slice(const BitMask& mask, int z, const Visit& visit) {
  for (int y = 0; y < mask.size()[1]; ++y) {
    const auto row = mask.row(y, z);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const int begin = static_cast<int>(i) * BitMask::kWordBits;
      for (auto word = row[i]; word != 0; word &= word - 1)
        visit(std::array{begin + std::countr_zero(word), y, z});
    }
  }
}

/// The same of all slices.
template <class Visit>
void for_each_voxel(const BitMask& mask, const Visit& visit) {
  for (int z = 0; z < mask.size()[2]; ++z) for_each_voxel_in_slice(mask, z, visit);
}

/// From `first` to before `end` along each axis.
struct VoxelBox {
  std::array<int, 3> first;
  std::array<int, 3> end;
};

/// The least one with all voxels that are set; of an empty mask it ends before it begins.
[[nodiscard]] VoxelBox box_of(const BitMask& mask);

/// Voxels with low_hu <= HU <= high_hu.
[[nodiscard]] BitMask threshold(const Volume& volume, double low_hu, double high_hu);

/// Dilation by a ball; what lies outside the volume is empty.
[[nodiscard]] BitMask dilated(const BitMask& mask,
                              double radius_mm,
                              const Eigen::Vector3d& spacing_mm);
/// Erosion by a ball; what lies outside the volume is full, so that a body which the scan cuts is
/// not eaten from its cut.
[[nodiscard]] BitMask eroded(BitMask mask, double radius_mm, const Eigen::Vector3d& spacing_mm);
[[nodiscard]] BitMask closed(const BitMask& mask,
                             double radius_mm,
                             const Eigen::Vector3d& spacing_mm);
[[nodiscard]] BitMask opened(BitMask mask, double radius_mm, const Eigen::Vector3d& spacing_mm);

}  // namespace mor::internal
