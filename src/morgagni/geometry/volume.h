// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/huge_pages.h"

namespace mor {

/// Beside the body, where table and air were: below all that a CT measures.
inline constexpr std::int16_t kOutsideHu = -2048;

using HuArray = std::vector<std::int16_t, HugePages<std::int16_t>>;

/// A CT: voxels in Hounsfield units on a right-angled grid.
struct Volume {
  std::array<int, 3> size{};                             ///< Voxels along x (fastest), y, z.
  Eigen::Vector3d spacing_mm = Eigen::Vector3d::Ones();  ///< Between voxel centres, > 0.
  Eigen::Isometry3d ct_from_grid =
      Eigen::Isometry3d::Identity();  ///< LPS mm from (i, j, k) * spacing_mm.
  HuArray hu;                         ///< size[0] * size[1] * size[2].
  std::string
      description;  ///< What the file says of itself (modality, series, patient id), one line.

  [[nodiscard]] std::size_t num_voxels() const { return hu.size(); }
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }
  /// @param grid_mm  Voxel times spacing. It may lie beside the volume, so does the voxel then.
  [[nodiscard]] Eigen::Vector3i nearest_voxel(const Eigen::Vector3d& grid_mm) const {
    return grid_mm.cwiseQuotient(spacing_mm).array().round().cast<int>();
  }
};

}  // namespace mor
