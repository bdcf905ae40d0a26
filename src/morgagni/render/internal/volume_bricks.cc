// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/volume_bricks.h"

#include <algorithm>
#include <limits>

#include <tbb/parallel_for.h>

namespace mor::internal {
namespace {

constexpr int kFarthest = 255;

/// Chebyshev distance along one axis after the other: each pass takes the least of
/// max(what the passes before found, the steps along this axis).
void spread_along(std::vector<std::uint8_t>& distances,
                  std::size_t first,
                  int count,
                  std::size_t step,
                  std::vector<std::uint8_t>& line) {
  line.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) line[static_cast<std::size_t>(i)] = distances[first + i * step];
  for (int i = 0; i < count; ++i) {
    int best = line[static_cast<std::size_t>(i)];
    for (int reach = 1; reach < best; ++reach) {
      for (const int j : {i - reach, i + reach}) {
        if (j < 0 || j >= count) continue;
        best = std::min(best, std::max<int>(reach, line[static_cast<std::size_t>(j)]));
      }
      if (i - reach < 0 && i + reach >= count) break;
    }
    distances[first + i * step] = static_cast<std::uint8_t>(best);
  }
}

}  // namespace

VolumeBricks::VolumeBricks(const Volume& volume) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size_[axis] = std::max(1, (volume.size[axis] - 1 + kCells - 1) / kCells);
  }
  ranges_.resize(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2]);
  tbb::parallel_for(0, size_[2], [&](int bz) {
    for (int by = 0; by < size_[1]; ++by) {
      for (int bx = 0; bx < size_[0]; ++bx) {
        Range range{std::numeric_limits<std::int16_t>::max(),
                    std::numeric_limits<std::int16_t>::min()};
        // A cell is interpolated from the voxels on both of its sides.
        const int end_x = std::min(bx * kCells + kCells + 1, volume.size[0]);
        const int end_y = std::min(by * kCells + kCells + 1, volume.size[1]);
        const int end_z = std::min(bz * kCells + kCells + 1, volume.size[2]);
        for (int z = bz * kCells; z < end_z; ++z) {
          for (int y = by * kCells; y < end_y; ++y) {
            const std::int16_t* row = volume.hu.data() + volume.index(0, y, z);
            const auto [least, most] = std::minmax_element(row + bx * kCells, row + end_x);
            range.least_hu = std::min(range.least_hu, *least);
            range.most_hu = std::max(range.most_hu, *most);
          }
        }
        ranges_[(static_cast<std::size_t>(bz) * size_[1] + by) * size_[0] + bx] = range;
      }
    }
  });
}

std::vector<std::uint8_t> VolumeBricks::distances_to_seen(const TransferTable& table) const {
  std::vector<std::uint8_t> distances(ranges_.size());
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const bool is_seen = table.is_seen(ranges_[i].least_hu, ranges_[i].most_hu);
    distances[i] = static_cast<std::uint8_t>(is_seen ? 0 : kFarthest);
  }
  std::vector<std::uint8_t> line;
  const auto nx = static_cast<std::size_t>(size_[0]);
  const auto ny = static_cast<std::size_t>(size_[1]);
  const auto nz = static_cast<std::size_t>(size_[2]);
  for (std::size_t i = 0; i < ny * nz; ++i) spread_along(distances, i * nx, size_[0], 1, line);
  for (std::size_t z = 0; z < nz; ++z) {
    for (std::size_t x = 0; x < nx; ++x) {
      spread_along(distances, z * nx * ny + x, size_[1], nx, line);
    }
  }
  for (std::size_t i = 0; i < nx * ny; ++i) spread_along(distances, i, size_[2], nx * ny, line);
  return distances;
}

}  // namespace mor::internal
