// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/smoothed_threshold.h"

#include <array>

#include <tbb/parallel_for.h>

namespace mor::internal {

BitMask smoothed_threshold(const Volume& volume,
                           const BitMask& within,
                           double low_hu,
                           double high_hu) {
  constexpr int kOwnWeight = 6;
  BitMask found(volume.size);
  tbb::parallel_for(0, volume.size[2], [&](int slice) {
    for_each_voxel_in_slice(within, slice, [&](const std::array<int, 3>& at) {
      int num = kOwnWeight;
      int sum = kOwnWeight * volume.hu[volume.index(at[0], at[1], at[2])];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const int step : {-1, 1}) {
          auto beside = at;
          beside[axis] += step;
          if (beside[axis] < 0 || beside[axis] >= volume.size[axis]) continue;
          sum += volume.hu[volume.index(beside[0], beside[1], beside[2])];
          ++num;
        }
      }
      if (sum >= low_hu * num && sum < high_hu * num) found.set_run(at[1], at[2], at[0], at[0] + 1);
    });
  });
  return found;
}

}  // namespace mor::internal
