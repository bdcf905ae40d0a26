// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/viewer_volume.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

struct Box {
  std::array<int, 3> first{};
  std::array<int, 3> size{};
};

/// The voxels of the body.
Box body_box(const Volume& volume) {
  std::array<int, 3> low = volume.size;
  std::array<int, 3> high = {-1, -1, -1};
  for (int z = 0; z < volume.size[2]; ++z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      for (int x = 0; x < volume.size[0]; ++x) {
        if (volume.hu[volume.index(x, y, z)] == kOutsideHu) continue;
        const std::array<int, 3> place = {x, y, z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], place[axis]);
          high[axis] = std::max(high[axis], place[axis]);
        }
      }
    }
  }
  if (high[0] < 0) return {{0, 0, 0}, volume.size};
  return {low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}};
}

/// Mean of the body's voxels in a block, as a code; 0 where most of the block is not the body.
std::uint8_t code_of_block(const Volume& volume,
                           const std::array<int, 3>& first,
                           const std::array<int, 3>& last) {
  double sum = 0.0;
  int num_body = 0;
  int num_all = 0;
  for (int z = first[2]; z < last[2]; ++z) {
    for (int y = first[1]; y < last[1]; ++y) {
      for (int x = first[0]; x < last[0]; ++x) {
        const auto hu = volume.hu[volume.index(x, y, z)];
        ++num_all;
        if (hu == kOutsideHu) continue;
        ++num_body;
        sum += hu;
      }
    }
  }
  return 2 * num_body > num_all ? code_of_hu(sum / num_body) : std::uint8_t{0};
}

}  // namespace

std::uint8_t code_of_hu(double hu) {
  const double clamped = std::clamp<double>(hu, kHuCodes.front().hu, kHuCodes.back().hu);
  for (std::size_t i = 1; i < kHuCodes.size(); ++i) {
    const auto& low = kHuCodes[i - 1];
    const auto& high = kHuCodes[i];
    if (clamped > high.hu) continue;
    const double share = (clamped - low.hu) / (high.hu - low.hu);
    return static_cast<std::uint8_t>(std::lround(low.code + share * (high.code - low.code)));
  }
  return static_cast<std::uint8_t>(kHuCodes.back().code);
}

ViewerVolume shrink_volume(const Volume& volume, int most_voxels) {
  const Box box = body_box(volume);
  ViewerVolume small;
  std::array<int, 3> block{};
  // Voxels of about one size on all sides: the longest side in mm sets it.
  double longest_mm = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    longest_mm =
        std::max(longest_mm, box.size[axis] * volume.spacing_mm[static_cast<Eigen::Index>(axis)]);
  }
  const double edge_mm = longest_mm / most_voxels;
  Eigen::Vector3d first_center;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double spacing_mm = volume.spacing_mm[static_cast<Eigen::Index>(axis)];
    block[axis] = std::max(1, static_cast<int>(std::ceil(edge_mm / spacing_mm - 1e-9)));
    small.size[axis] = (box.size[axis] + block[axis] - 1) / block[axis];
    small.spacing_mm[static_cast<Eigen::Index>(axis)] = block[axis] * spacing_mm;
    first_center[static_cast<Eigen::Index>(axis)] =
        (box.first[axis] + 0.5 * (block[axis] - 1)) * spacing_mm;
  }
  small.ct_from_grid = volume.ct_from_grid * Eigen::Translation3d(first_center);
  small.codes.reserve(static_cast<std::size_t>(small.size[0]) * small.size[1] * small.size[2]);
  for (int z = 0; z < small.size[2]; ++z) {
    for (int y = 0; y < small.size[1]; ++y) {
      for (int x = 0; x < small.size[0]; ++x) {
        const std::array<int, 3> place = {x, y, z};
        std::array<int, 3> first{};
        std::array<int, 3> last{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          first[axis] = box.first[axis] + place[axis] * block[axis];
          last[axis] = std::min(first[axis] + block[axis], box.first[axis] + box.size[axis]);
        }
        small.codes += static_cast<char>(code_of_block(volume, first, last));
      }
    }
  }
  return small;
}

}  // namespace mor::internal
