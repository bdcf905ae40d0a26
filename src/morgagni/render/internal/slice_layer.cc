// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/slice_layer.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

namespace mor::internal {
namespace {

constexpr float kEdgeFrom =
    0.35F;                        ///< Share of the body's voxels around a point at which the slice
constexpr float kEdgeTo = 0.75F;  ///< begins, and is complete.
constexpr std::int16_t kAirHu = -1000;

Eigen::AlignedBox3d bounds_of(const Volume& volume, const Eigen::Isometry3d& frame_from_ct) {
  Eigen::AlignedBox3d bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d voxel((corner & 1) * (volume.size[0] - 1),
                                (corner >> 1 & 1) * (volume.size[1] - 1),
                                (corner >> 2 & 1) * (volume.size[2] - 1));
    bounds.extend(frame_from_ct * (volume.ct_from_grid * voxel.cwiseProduct(volume.spacing_mm)));
  }
  return bounds;
}

struct Sample {
  float hu = 0.0F;
  float body_share = 0.0F;  ///< Of the eight voxels around, by their weights.
};

/// @param at  In voxels. Nothing outside of the grid.
Sample sample(const Volume& volume, const Eigen::Vector3f& at) {
  const Eigen::Vector3f last =
      Eigen::Vector3i(volume.size[0] - 1, volume.size[1] - 1, volume.size[2] - 1).cast<float>();
  if ((at.array() < 0.0F).any() || (at.array() > last.array()).any()) return {};
  const int x = std::min(static_cast<int>(at.x()), volume.size[0] - 2);
  const int y = std::min(static_cast<int>(at.y()), volume.size[1] - 2);
  const int z = std::min(static_cast<int>(at.z()), volume.size[2] - 2);
  const float u = at.x() - static_cast<float>(x);
  const float v = at.y() - static_cast<float>(y);
  const float w = at.z() - static_cast<float>(z);
  Sample result;
  for (int corner = 0; corner < 8; ++corner) {
    const int right = corner & 1;
    const int back = corner >> 1 & 1;
    const int up = corner >> 2 & 1;
    const float weight =
        (right != 0 ? u : 1.0F - u) * (back != 0 ? v : 1.0F - v) * (up != 0 ? w : 1.0F - w);
    const std::int16_t hu = volume.hu[volume.index(x + right, y + back, z + up)];
    result.hu += weight * static_cast<float>(hu == kOutsideHu ? kAirHu : hu);
    if (hu != kOutsideHu) result.body_share += weight;
  }
  return result;
}

Rgba8 grey_of(const SliceView& slice, const Sample& sample) {
  const float share = (sample.body_share - kEdgeFrom) / (kEdgeTo - kEdgeFrom);
  const float alpha = std::clamp(share, 0.0F, 1.0F) * slice.opacity;
  const float light = std::clamp((sample.hu - slice.level_hu) / slice.window_hu + 0.5F, 0.0F, 1.0F);
  const auto grey = static_cast<std::uint8_t>(std::lround(255.0F * light * alpha));
  return {grey, grey, grey, static_cast<std::uint8_t>(std::lround(255.0F * alpha))};
}

}  // namespace

std::optional<Eigen::Hyperplane<double, 3>> slice_plane(const SliceView& slice,
                                                        const Volume& volume,
                                                        const Eigen::Isometry3d& color_from_ct,
                                                        double skin_mm) {
  using Plane = Eigen::Hyperplane<double, 3>;
  if (slice.plane == SlicePlane::kNone) return std::nullopt;
  if (slice.plane == SlicePlane::kCamera) {
    const double from_mm = skin_mm > 0.0 ? skin_mm : bounds_of(volume, color_from_ct).min().z();
    return Plane(Eigen::Vector3d::UnitZ(), -(from_mm + static_cast<double>(slice.depth_mm)));
  }
  // LPS: x to the body's left, y to its back, z to its head.
  const int axis = slice.plane == SlicePlane::kAxial     ? 2
                   : slice.plane == SlicePlane::kCoronal ? 1
                                                         : 0;
  const Eigen::AlignedBox3d bounds = bounds_of(volume, Eigen::Isometry3d::Identity());
  Eigen::Vector3d place = bounds.center();
  place[axis] = bounds.min()[axis] +
                static_cast<double>(slice.position) * (bounds.max()[axis] - bounds.min()[axis]);
  Plane plane(color_from_ct.linear().col(axis), color_from_ct * place);
  if (plane.offset() > 0.0) plane.coeffs() = -plane.coeffs();
  return plane;
}

void draw_slice(const SliceView& slice,
                const Eigen::Hyperplane<double, 3>& plane,
                const Volume& volume,
                const Eigen::Isometry3d& color_from_ct,
                const PictureRays& rays,
                Layer& layer) {
  const Eigen::Isometry3d grid_from_color = (color_from_ct * volume.ct_from_grid).inverse();
  const Eigen::Vector3d per_mm = volume.spacing_mm.cwiseInverse();
  const Eigen::Matrix3f voxels_per_mm =
      (per_mm.asDiagonal() * grid_from_color.linear()).cast<float>();
  const Eigen::Vector3f eye = grid_from_color.translation().cwiseProduct(per_mm).cast<float>();
  const Eigen::Vector3f normal = plane.normal().cast<float>();
  const auto offset_mm = static_cast<float>(plane.offset());
  const PixelBox& box = layer.box;
  tbb::parallel_for(box.top, box.top + box.height, [&](int y) {
    const std::size_t start = layer.row_start(y);
    for (int x = 0; x < box.width; ++x) {
      const Eigen::Vector2f& ray = rays.row(y)[box.left + x];
      const Eigen::Vector3f direction(ray.x(), ray.y(), 1.0F);
      const float slope = normal.dot(direction);
      if (std::abs(slope) < 1e-6F) continue;
      const float depth_mm = -offset_mm / slope;
      if (!(depth_mm > 1.0F)) continue;
      const Rgba8 grey =
          grey_of(slice, sample(volume, eye + depth_mm * (voxels_per_mm * direction)));
      if (grey.a == 0) continue;
      layer.pixels[start + static_cast<std::size_t>(x)] = grey;
      layer.depth_mm[start + static_cast<std::size_t>(x)] = depth_mm;
    }
  });
}

}  // namespace mor::internal
