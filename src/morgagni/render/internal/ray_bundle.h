// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/volume.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/view_grid.h"

/// What the casters on the CPU and on a GPU share.
namespace mor::internal {

/// The rays of one picture.
struct RayBundle {
  const PictureRays* rays = nullptr;
  Eigen::Isometry3d color_from_ct = Eigen::Isometry3d::Identity();
  std::span<const Layer> layers = {};  ///< What the rays meet besides the volume.
  /// Colour frame; the volume on the camera's side of it is not seen. None: all of it is.
  std::optional<Eigen::Hyperplane<double, 3>> cut = {};
  const ViewGrid* grid = nullptr;  ///< Where the skin is, and
  float skin_mm = 0.0F;            ///< so much below it the rays begin and end. 0: beside it.
  int stride_px = 1;  ///< One ray every so many pixels a side; between them it is interpolated.
  float ray_spacing = 0.0F;  ///< Between neighbouring rays, of their length: voxels much finer than
                             ///< that are taken from a coarser volume. 0: never.
  bool is_still = true;      ///< Else somewhat coarser voxels will do.
  std::function<bool(int x, int y)> is_open =
      {};  ///< Pixels of which nothing is seen cost nothing.
};

/// Places in a ray's picture and in the volume.
struct RayGeometry {
  std::array<int, 3> size;
  std::array<float, 3> eye;              ///< In voxels.
  Eigen::Matrix3f voxels_from_ray;       ///< Voxels a mm of z, of (x/z, y/z, 1).
  Eigen::Matrix3f color_from_gradient;   ///< HU a voxel in the grid to HU a mm in the colour frame.
  std::array<float, 3> gradient_voxels;  ///< From a sample to those that say where it faces.
  float nearest_mm;                      ///< z of the volume's nearest
  float farthest_mm;                     ///< and farthest corner.
};

[[nodiscard]] RayGeometry ray_geometry(const Volume& volume,
                                       const Eigen::Isometry3d& color_from_ct);

/// The part of a ray (x/z, y/z) that may be seen, z; the volume's own ends are not in it.
struct RayLimits {
  float first_mm = 1.0F;
  float last_mm = kNoDepth;
};

[[nodiscard]] RayLimits ray_limits(const RayBundle& bundle, const Eigen::Vector2f& ray);

/// The pixels of a box that get a ray: one more than fits, so that each pixel lies between two.
struct RayRaster {
  RayRaster(const PixelBox& pixels, int stride_px)
      : box(pixels),
        stride(stride_px),
        width((box.width - 1) / stride + (stride > 1 ? 2 : 1)),
        height((box.height - 1) / stride + (stride > 1 ? 2 : 1)) {}

  [[nodiscard]] int column(int x) const {
    return std::min(box.left + x * stride, box.left + box.width - 1);
  }
  [[nodiscard]] int row(int y) const {
    return std::min(box.top + y * stride, box.top + box.height - 1);
  }
  /// Colours of the rays to colours of the pixels.
  void spread(std::vector<Rgba8> colors, Layer& seen) const;

  PixelBox box;
  int stride;
  int width;
  int height;
};

}  // namespace mor::internal
