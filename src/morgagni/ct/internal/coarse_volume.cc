// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/coarse_volume.h"

namespace mor::internal {

Volume coarse_volume(const Volume& volume, double small_mm) {
  std::array<int, 3> step{};
  Volume coarse;
  coarse.ct_from_grid = volume.ct_from_grid;
  coarse.description = volume.description;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double spacing_mm = volume.spacing_mm[static_cast<int>(axis)];
    step[axis] = spacing_mm < small_mm ? 2 : 1;
    coarse.size[axis] = (volume.size[axis] + step[axis] - 1) / step[axis];
    coarse.spacing_mm[static_cast<int>(axis)] = spacing_mm * step[axis];
  }
  coarse.hu.reserve(static_cast<std::size_t>(coarse.size[0]) *
                    static_cast<std::size_t>(coarse.size[1]) *
                    static_cast<std::size_t>(coarse.size[2]));
  for (int z = 0; z < coarse.size[2]; ++z)
    for (int y = 0; y < coarse.size[1]; ++y)
      for (int x = 0; x < coarse.size[0]; ++x)
        coarse.hu.push_back(volume.hu[volume.index(x * step[0], y * step[1], z * step[2])]);
  return coarse;
}

}  // namespace mor::internal
