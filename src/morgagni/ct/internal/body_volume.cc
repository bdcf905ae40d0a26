// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/body_volume.h"

#include <algorithm>
#include <array>

namespace mor::internal {
namespace {

/// Of air around the body: the skin keeps both of its sides, for whoever interpolates there.
constexpr double kAirVoxels = 2.0;
constexpr int kLeastHu = -1024;
constexpr int kMostHu = 3071;

struct VoxelBox {
  std::array<int, 3> first;
  std::array<int, 3> end;
};

VoxelBox box_of(const BitMask& mask) {
  VoxelBox box{mask.size(), {0, 0, 0}};
  for (int z = 0; z < mask.size()[2]; ++z) {
    for (int y = 0; y < mask.size()[1]; ++y) {
      for (int x = 0; x < mask.size()[0]; ++x) {
        if (!mask.test(x, y, z)) continue;
        const std::array<int, 3> at = {x, y, z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          box.first[axis] = std::min(box.first[axis], at[axis]);
          box.end[axis] = std::max(box.end[axis], at[axis] + 1);
        }
      }
    }
  }
  return box;
}

}  // namespace

Volume body_volume(const Volume& volume, const BitMask& body) {
  const BitMask kept = dilated(body, kAirVoxels, Eigen::Vector3d::Ones());
  const auto [first, end] = box_of(kept);
  Volume result;
  result.spacing_mm = volume.spacing_mm;
  result.description = volume.description;
  result.ct_from_grid = volume.ct_from_grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.size[axis] = std::max(end[axis] - first[axis], 0);
  }
  const Eigen::Vector3d corner(first[0], first[1], first[2]);
  result.ct_from_grid.translation() = volume.ct_from_grid * corner.cwiseProduct(volume.spacing_mm);
  result.hu.reserve(static_cast<std::size_t>(result.size[0]) * result.size[1] * result.size[2]);
  for (int z = first[2]; z < end[2]; ++z) {
    for (int y = first[1]; y < end[1]; ++y) {
      for (int x = first[0]; x < end[0]; ++x) {
        const int hu = std::clamp<int>(volume.hu[volume.index(x, y, z)], kLeastHu, kMostHu);
        result.hu.push_back(kept.test(x, y, z) ? static_cast<std::int16_t>(hu) : kOutsideHu);
      }
    }
  }
  return result;
}

}  // namespace mor::internal
