// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/components.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace mor::internal {
namespace {

using Word = BitMask::Word;

/// The first voxel at or after `x` whose bit differs from `value`; `size_x` if there is none.
int next_change(std::span<const Word> row, int x, bool value, int size_x) {
  while (x < size_x) {
    const Word flip = value ? ~Word{0} : Word{0};
    const Word left =
        (row[static_cast<std::size_t>(x / BitMask::kWordBits)] ^ flip) >> (x % BitMask::kWordBits);
    if (left != 0) return std::min(size_x, x + std::countr_zero(left));
    x = (x / BitMask::kWordBits + 1) * BitMask::kWordBits;
  }
  return size_x;
}

}  // namespace

Components::Components(const BitMask& mask) : size_(mask.size()) {
  find_runs(mask);
  parents_.resize(runs_.size());
  std::iota(parents_.begin(), parents_.end(), 0U);
  join_rows();
  number_parts();
}

void Components::find_runs(const BitMask& mask) {
  const auto [size_x, size_y, size_z] = size_;
  for (int z = 0; z < size_z; ++z) {
    for (int y = 0; y < size_y; ++y) {
      row_starts_.push_back(runs_.size());
      const auto row = mask.row(y, z);
      for (int x = next_change(row, 0, false, size_x); x < size_x;) {
        const int end = next_change(row, x, true, size_x);
        runs_.push_back({y, z, x, end, 0});
        x = next_change(row, end, false, size_x);
      }
    }
  }
  row_starts_.push_back(runs_.size());
}

std::uint32_t Components::root(std::uint32_t run) {
  while (parents_[run] != run) {
    parents_[run] = parents_[parents_[run]];
    run = parents_[run];
  }
  return run;
}

void Components::join_rows() {
  const auto join = [&](std::size_t row_a, std::size_t row_b) {
    std::size_t a = row_starts_[row_a];
    std::size_t b = row_starts_[row_b];
    while (a < row_starts_[row_a + 1] && b < row_starts_[row_b + 1]) {
      if (runs_[a].begin < runs_[b].end && runs_[b].begin < runs_[a].end) {
        const auto root_a = root(static_cast<std::uint32_t>(a));
        const auto root_b = root(static_cast<std::uint32_t>(b));
        parents_[std::max(root_a, root_b)] = std::min(root_a, root_b);
      }
      ++(runs_[a].end < runs_[b].end ? a : b);
    }
  };
  const auto size_y = static_cast<std::size_t>(size_[1]);
  for (std::size_t row = 0; row + 1 < row_starts_.size(); ++row) {
    if (row % size_y != 0) join(row, row - 1);
    if (row >= size_y) join(row, row - size_y);
  }
}

void Components::number_parts() {
  // A root is the first run of its part: numbers are given before they are asked for.
  for (std::uint32_t i = 0; i < runs_.size(); ++i) {
    const std::uint32_t first = root(i);
    if (first == i) {
      runs_[i].part = static_cast<std::uint32_t>(parts_.size());
      parts_.push_back({.low_x = runs_[i].begin, .low_y = runs_[i].y, .low_z = runs_[i].z});
    }
    runs_[i].part = runs_[first].part;
    measure(runs_[i]);
  }
  parents_.clear();
  parents_.shrink_to_fit();
}

void Components::measure(const Run& run) {
  Part& part = parts_[run.part];
  part.num_voxels += static_cast<std::size_t>(run.end - run.begin);
  part.low_x = std::min(part.low_x, run.begin);
  part.high_x = std::max(part.high_x, run.end - 1);
  part.low_y = std::min(part.low_y, run.y);
  part.high_y = std::max(part.high_y, run.y);
  part.high_z = run.z;
  part.at_side =
      part.at_side || run.begin == 0 || run.end == size_[0] || run.y == 0 || run.y == size_[1] - 1;
}

std::size_t Components::largest() const {
  const auto most =
      std::max_element(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
        return a.num_voxels < b.num_voxels;
      });
  return static_cast<std::size_t>(most - parts_.begin());
}

BitMask Components::select(const std::function<bool(std::size_t)>& wanted) const {
  std::vector<char> chosen(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) chosen[i] = wanted(i) ? 1 : 0;
  BitMask mask(size_);
  for (const Run& run : runs_)
    if (chosen[run.part] != 0) mask.set_run(run.y, run.z, run.begin, run.end);
  return mask;
}

std::optional<std::size_t> Components::part_at(const std::array<int, 3>& voxel) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (voxel[axis] < 0 || voxel[axis] >= size_[axis]) return std::nullopt;
  const std::size_t row = static_cast<std::size_t>(voxel[2]) * static_cast<std::size_t>(size_[1]) +
                          static_cast<std::size_t>(voxel[1]);
  for (std::size_t i = row_starts_[row]; i < row_starts_[row + 1]; ++i)
    if (runs_[i].begin <= voxel[0] && voxel[0] < runs_[i].end) return runs_[i].part;
  return std::nullopt;
}

std::vector<std::array<int, 3>> Components::samples(std::size_t part, std::size_t num) const {
  std::vector<const Run*> runs;
  for (const Run& run : runs_)
    if (run.part == part) runs.push_back(&run);
  num = std::min(num, runs.size());
  std::vector<std::array<int, 3>> voxels;
  for (std::size_t i = 0; i < num; ++i) {
    const Run& run = *runs[(2 * i + 1) * runs.size() / (2 * num)];
    voxels.push_back({(run.begin + run.end - 1) / 2, run.y, run.z});
  }
  return voxels;
}

std::vector<std::size_t> Components::overlap(const BitMask& other) const {
  std::vector<std::size_t> counts(parts_.size());
  for (const Run& run : runs_) {
    const auto row = other.row(run.y, run.z);
    for (int x = next_change(row, run.begin, false, run.end); x < run.end;) {
      const int end = next_change(row, x, true, run.end);
      counts[run.part] += static_cast<std::size_t>(end - x);
      x = next_change(row, end, false, run.end);
    }
  }
  return counts;
}

}  // namespace mor::internal
