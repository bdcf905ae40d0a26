// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/ray_bundle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

namespace mor::internal {
namespace {

/// Between a sample and those that say where it faces: a voxel, and of the longest voxel's side at
/// least so much, else slices that are farther apart than pixels show as terraces.
constexpr double kGradientReach = 0.8;

}  // namespace

RayGeometry ray_geometry(const Volume& volume, const Eigen::Isometry3d& color_from_ct) {
  RayGeometry geometry{};
  geometry.size = volume.size;
  const Eigen::Isometry3d grid_from_color = (color_from_ct * volume.ct_from_grid).inverse();
  const Eigen::Vector3d per_mm = volume.spacing_mm.cwiseInverse();
  const Eigen::Vector3d eye = grid_from_color.translation().cwiseProduct(per_mm);
  const double reach_mm = kGradientReach * volume.spacing_mm.maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    geometry.eye[static_cast<std::size_t>(axis)] = static_cast<float>(eye[axis]);
    geometry.gradient_voxels[static_cast<std::size_t>(axis)] =
        static_cast<float>(std::max(1.0, reach_mm * per_mm[axis]));
  }
  geometry.voxels_from_ray = (per_mm.asDiagonal() * grid_from_color.linear()).cast<float>();
  geometry.color_from_gradient =
      (grid_from_color.linear().transpose() * per_mm.asDiagonal()).cast<float>();
  geometry.nearest_mm = kNoDepth;
  geometry.farthest_mm = -kNoDepth;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d voxel((corner & 1) * (volume.size[0] - 1),
                                (corner >> 1 & 1) * (volume.size[1] - 1),
                                (corner >> 2 & 1) * (volume.size[2] - 1));
    const Eigen::Vector3d place = grid_from_color.inverse() * voxel.cwiseProduct(volume.spacing_mm);
    geometry.nearest_mm = std::min(geometry.nearest_mm, static_cast<float>(place.z()));
    geometry.farthest_mm = std::max(geometry.farthest_mm, static_cast<float>(place.z()) + 1.0F);
  }
  return geometry;
}

RayLimits ray_limits(const RayBundle& bundle, const Eigen::Vector2f& ray) {
  RayLimits limits;
  if (bundle.cut) {
    // What is on the camera's side of the plane is not there.
    const auto slope =
        static_cast<float>(bundle.cut->normal().dot(Eigen::Vector3d(ray.x(), ray.y(), 1.0)));
    const float safe = std::abs(slope) < 1e-6F ? 1e-6F : slope;
    const float meets_mm = -static_cast<float>(bundle.cut->offset()) / safe;
    limits.first_mm = meets_mm > 0.0F ? std::max(limits.first_mm, meets_mm) : kNoDepth;
  }
  if (bundle.grid == nullptr || bundle.skin_mm <= 0.0F) return limits;
  const float skin_mm = bundle.grid->skin_at(ray);
  const float back_mm = bundle.grid->back_at(ray);
  if (skin_mm > 0.0F) limits.first_mm = std::max(limits.first_mm, skin_mm + bundle.skin_mm);
  if (back_mm > 0.0F) limits.last_mm = back_mm - bundle.skin_mm;
  return limits;
}

void RayRaster::spread(std::vector<Rgba8> coarse, Layer& seen) const {
  if (stride == 1) {
    seen.pixels = std::move(coarse);
    return;
  }
  tbb::parallel_for(0, box.height, [&](int y) {
    const Rgba8* upper = coarse.data() + static_cast<std::size_t>(y / stride) * width;
    const Rgba8* lower = upper + width;
    const int down = y % stride;
    Rgba8* row = seen.pixels.data() + static_cast<std::size_t>(y) * box.width;
    for (int x = 0; x < box.width; ++x) {
      const int column = x / stride;
      const int right = x % stride;
      const auto mixed = [&](std::uint8_t Rgba8::*channel) {
        const int above =
            upper[column].*channel * (stride - right) + upper[column + 1].*channel * right;
        const int below =
            lower[column].*channel * (stride - right) + lower[column + 1].*channel * right;
        return static_cast<std::uint8_t>((above * (stride - down) + below * down) /
                                         (stride * stride));
      };
      row[x] = {mixed(&Rgba8::r), mixed(&Rgba8::g), mixed(&Rgba8::b), mixed(&Rgba8::a)};
    }
  });
}

}  // namespace mor::internal
