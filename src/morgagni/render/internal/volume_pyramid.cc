// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/volume_pyramid.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <tbb/parallel_for.h>

namespace mor::internal {
namespace {

constexpr int kLeastSize = 8;     ///< Voxels along an axis that is still halved.
constexpr int kAirHu = -1024;     ///< What is beside the body is no less.
constexpr double kAsLong = 1.45;  ///< Times the shortest: an axis that waits for the others.

/// Every second voxel along an axis, 1-2-1 with those beside it. The last one stands at or beyond
/// the last of `fine`, so that nothing is lost.
Volume halved(const Volume& fine, std::size_t axis) {
  Volume coarse;
  coarse.size = fine.size;
  coarse.size[axis] = fine.size[axis] / 2 + 1;
  coarse.spacing_mm = fine.spacing_mm;
  coarse.spacing_mm[static_cast<Eigen::Index>(axis)] *= 2.0;
  coarse.ct_from_grid = fine.ct_from_grid;
  const auto [nx, ny, nz] = coarse.size;
  coarse.hu.resize(coarse.index(0, 0, nz));
  const int last = fine.size[axis] - 1;
  tbb::parallel_for(0, nz, [&, nx = nx, ny = ny](int z) {
    for (int y = 0; y < ny; ++y) {
      std::int16_t* const row = coarse.hu.data() + coarse.index(0, y, z);
      const int at = 2 * (axis == 1 ? y : z);
      const auto line = [&](int place) {
        const int here = std::clamp(place, 0, last);
        return fine.hu.data() + fine.index(0, axis == 1 ? here : y, axis == 2 ? here : z);
      };
      const std::int16_t* const before = axis == 0 ? line(0) : line(at - 1);
      const std::int16_t* const middle = axis == 0 ? before : line(at);
      const std::int16_t* const after = axis == 0 ? before : line(at + 1);
      for (int x = 0; x < nx; ++x) {
        const auto place = [&](int step) {
          return axis == 0 ? std::clamp(2 * x + step, 0, last) : x;
        };
        const auto air_at_least = [](std::int16_t hu) { return std::max<int>(hu, kAirHu); };
        const int sum = air_at_least(before[place(-1)]) + 2 * air_at_least(middle[place(0)]) +
                        air_at_least(after[place(1)]);
        row[x] = static_cast<std::int16_t>((sum + 2) >> 2);
      }
    }
  });
  return coarse;
}

}  // namespace

std::vector<std::shared_ptr<const Volume>> make_volume_pyramid(std::shared_ptr<const Volume> volume,
                                                               int most_levels) {
  std::vector levels{std::move(volume)};
  while (static_cast<int>(levels.size()) < most_levels) {
    const Volume& fine = *levels.back();
    const double least_mm = fine.spacing_mm.minCoeff();
    std::shared_ptr<const Volume> coarse;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool waits = fine.spacing_mm[static_cast<Eigen::Index>(axis)] > kAsLong * least_mm;
      if (waits || fine.size[axis] < kLeastSize) continue;
      coarse = std::make_shared<const Volume>(halved(coarse ? *coarse : fine, axis));
    }
    if (!coarse) break;
    levels.push_back(std::move(coarse));
  }
  return levels;
}

}  // namespace mor::internal
