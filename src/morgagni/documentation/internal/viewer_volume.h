// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// A CT made small for a page: the body's box, 8 bits a voxel.
struct ViewerVolume {
  std::array<int, 3> size{};
  Eigen::Vector3d spacing_mm = Eigen::Vector3d::Ones();
  Eigen::Isometry3d ct_from_grid =
      Eigen::Isometry3d::Identity();  ///< LPS mm from (i, j, k) * spacing_mm.
  std::string codes;                  ///< size[0] * size[1] * size[2]; x fastest; 0: not the body.
};

/// What the codes mean: straight between these. Fine where soft tissue lies.
struct HuCode {
  int code;
  int hu;
};
inline constexpr std::array<HuCode, 4> kHuCodes = {
    {{1, -1000}, {51, -200}, {176, 300}, {255, 1880}}};

[[nodiscard]] std::uint8_t code_of_hu(double hu);

/// Voxels are averaged together until no side is longer than `most_voxels`.
[[nodiscard]] ViewerVolume shrink_volume(const Volume& volume, int most_voxels);

}  // namespace mor::internal
