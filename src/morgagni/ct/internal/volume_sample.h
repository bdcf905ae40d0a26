// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// HU between the voxels around a place of the grid, linear. None beyond the outermost voxels'
/// centres.
/// @param grid_mm  As in `ct_from_grid * grid_mm`.
[[nodiscard]] inline std::optional<double> sampled_hu(const Volume& volume,
                                                      const Eigen::Vector3d& grid_mm) {
  constexpr double kRounding = 1e-6;
  std::array<int, 3> low{};
  std::array<double, 3> share{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double at = grid_mm[axis] / volume.spacing_mm[axis];
    const int last = volume.size[i] - 1;
    if (!(at >= -kRounding && at <= last + kRounding)) return std::nullopt;
    // A place on a voxel is that voxel, whatever the rounding of its coordinates.
    const double near = std::rint(at);
    const double exact = std::clamp(std::abs(at - near) < kRounding ? near : at, 0.0, 1.0 * last);
    low[i] = std::min(static_cast<int>(exact), std::max(last - 1, 0));
    share[i] = exact - low[i];
  }
  const std::size_t first = volume.index(low[0], low[1], low[2]);
  const std::array<std::size_t, 3> step = {volume.size[0] > 1 ? std::size_t{1} : 0,
                                           volume.size[1] > 1 ? volume.index(0, 1, 0) : 0,
                                           volume.size[2] > 1 ? volume.index(0, 0, 1) : 0};
  const auto along_x = [&](std::size_t at) {
    return volume.hu[at] + share[0] * (volume.hu[at + step[0]] - volume.hu[at]);
  };
  const auto along_y = [&](std::size_t at) {
    const double here = along_x(at);
    return here + share[1] * (along_x(at + step[1]) - here);
  };
  const double here = along_y(first);
  return here + share[2] * (along_y(first + step[2]) - here);
}

}  // namespace mor::internal
