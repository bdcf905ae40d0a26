// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/body_block.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/coarse_volume.h"
#include "morgagni/ct/internal/uncovering.h"
#include "morgagni/ct/internal/volume_sample.h"

namespace mor::internal {
namespace {

Eigen::AlignedBox3d box_of(const Volume& volume) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d mm;
    for (int axis = 0; axis < 3; ++axis)
      mm[axis] = (corner >> axis & 1) * (volume.size[static_cast<std::size_t>(axis)] - 1) *
                 volume.spacing_mm[axis];
    box.extend(volume.ct_from_grid * mm);
  }
  return box;
}

/// What is not the body becomes air; all of it stays where no body can be told from air.
void keep_body(Volume& volume) {
  const auto found = body_mask(volume, bare_ct(volume), {}, {});
  for (int z = 0; z < volume.size[2]; ++z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      for (int x = 0; x < volume.size[0]; ++x) {
        std::int16_t& hu = volume.hu[volume.index(x, y, z)];
        const bool is_body = !found || found->body.test(x, y, z);
        hu = is_body ? std::clamp<std::int16_t>(hu, kLeastTissueHu, kMostTissueHu) : kLeastTissueHu;
      }
    }
  }
}

/// Of the eight corners of a cube half as large.
std::int16_t mean_hu(const Volume& volume,
                     const Eigen::Isometry3d& grid_from_ct,
                     const Eigen::Vector3d& middle_mm,
                     double cube_mm) {
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d to_corner(
        corner & 1 ? 0.25 : -0.25, corner & 2 ? 0.25 : -0.25, corner & 4 ? 0.25 : -0.25);
    const auto hu = sampled_hu(volume, grid_from_ct * (middle_mm + cube_mm * to_corner));
    sum += hu.value_or(kLeastTissueHu);
  }
  return static_cast<std::int16_t>(std::lround(sum / 8.0));
}

}  // namespace

Volume body_block(const Volume& volume, double cube_mm) {
  Volume coarse = coarse_volume(volume, 0.5 * cube_mm);
  keep_body(coarse);
  const auto box = box_of(coarse);
  Volume block;
  block.spacing_mm.setConstant(cube_mm);
  block.ct_from_grid.translation() = box.min();
  for (int axis = 0; axis < 3; ++axis)
    block.size[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::lround(box.sizes()[axis] / cube_mm)) + 1;
  block.hu.reserve(static_cast<std::size_t>(block.size[0]) *
                   static_cast<std::size_t>(block.size[1]) *
                   static_cast<std::size_t>(block.size[2]));
  const Eigen::Isometry3d grid_from_ct = coarse.ct_from_grid.inverse();
  for (int z = 0; z < block.size[2]; ++z)
    for (int y = 0; y < block.size[1]; ++y)
      for (int x = 0; x < block.size[0]; ++x)
        block.hu.push_back(mean_hu(coarse,
                                   grid_from_ct,
                                   block.ct_from_grid * (cube_mm * Eigen::Vector3d(x, y, z)),
                                   cube_mm));
  return block;
}

}  // namespace mor::internal
