// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/registration/fixed_surface.h"
#include "morgagni/registration/start.h"

namespace mor::internal {

/// What a measured point is worth at a place about the CT's body, on a grid: most on the skin,
/// nothing away from it, less than nothing inside the body, where no camera sees.
///
/// The grid stands as the body lies: frame `lying`, its z axis up from the table, which touches the
/// body at z = 0.
struct StartVolume {
  static constexpr int kMostWorth = 50;
  static constexpr int kRowStep = 16;  ///< So many nodes are added up at once.

  Eigen::Isometry3d lying_from_ct = Eigen::Isometry3d::Identity();
  Eigen::Vector3f origin_mm = Eigen::Vector3f::Zero();  ///< Of node (0, 0, 0), frame lying.
  float spacing_mm = 1.0F;
  std::array<int, 3> size{};  ///< Nodes along x, y, z.
  int stride = 0;  ///< Nodes from row to row: whole steps, those beyond the size worth nothing.
  std::vector<std::int8_t> worth;

  [[nodiscard]] std::int8_t* row(int y, int z) { return worth.data() + row_offset(y, z); }
  [[nodiscard]] const std::int8_t* row(int y, int z) const {
    return worth.data() + row_offset(y, z);
  }

 private:
  [[nodiscard]] std::ptrdiff_t row_offset(int y, int z) const {
    return (static_cast<std::ptrdiff_t>(z) * size[1] + y) * stride;
  }
};

struct StartVolumeOptions {
  float nodes_along_body = 48.0F;
  float reach_nodes = 3.5F;  ///< How far from the skin a point is worth something.
};

[[nodiscard]] StartVolume make_start_volume(const FixedSurface& fixed,
                                            BodySide lying_on,
                                            const StartVolumeOptions& options);

}  // namespace mor::internal
