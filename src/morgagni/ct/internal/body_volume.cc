// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/body_volume.h"

#include <algorithm>
#include <array>

#include <tbb/parallel_for.h>

namespace mor::internal {
namespace {

/// Of air around the body: the skin keeps both of its sides, for whoever interpolates there.
constexpr double kAirVoxels = 2.0;
constexpr int kLeastHu = -1024;
constexpr int kMostHu = 3071;

}  // namespace

Volume body_volume(const Volume& volume, const BitMask& body) {
  const BitMask kept = dilated(body, kAirVoxels, Eigen::Vector3d::Ones());
  const VoxelBox box = box_of(kept);
  Volume result;
  result.spacing_mm = volume.spacing_mm;
  result.description = volume.description;
  result.ct_from_grid = volume.ct_from_grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.size[axis] = std::max(box.end[axis] - box.first[axis], 0);
  }
  const Eigen::Vector3d corner(box.first[0], box.first[1], box.first[2]);
  result.ct_from_grid.translation() = volume.ct_from_grid * corner.cwiseProduct(volume.spacing_mm);
  result.hu.resize(result.index(0, 0, result.size[2]));
  tbb::parallel_for(box.first[2], box.end[2], [&](int z) {
    auto* to = result.hu.data() + result.index(0, 0, z - box.first[2]);
    for (int y = box.first[1]; y < box.end[1]; ++y) {
      for (int x = box.first[0]; x < box.end[0]; ++x) {
        const int hu = std::clamp<int>(volume.hu[volume.index(x, y, z)], kLeastHu, kMostHu);
        *to++ = kept.test(x, y, z) ? static_cast<std::int16_t>(hu) : kOutsideHu;
      }
    }
  });
  return result;
}

}  // namespace mor::internal
