// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/transfer_table.h"
#include "morgagni/render/internal/view_grid.h"
#include "morgagni/render/internal/volume_bricks.h"

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

/// Draws the CT's volume together with the layers, by rays from the camera (front to back, one
/// sample a voxel, lit by the gradient), eight at a time. A sample stands for all HU between it and
/// the one before, so that steep transfer functions leave no rings. Transparent bricks are leapt
/// over; a ray ends where nothing shines through any more. The voxels are about as far apart as the
/// rays: nothing glitters, and what is far away or moves costs less.
/// @threads cast() uses all cores; one call at a time.
class RayCaster {
 public:
  explicit RayCaster(std::shared_ptr<const Volume> volume);

  /// What is to be seen. Costs milliseconds where it changed.
  void set(const VolumeView& view);

  /// @param seen  Of the box that it has: the volume and the layers in one.
  void cast(const RayBundle& bundle, Layer& seen) const;

  /// Of the volume as it is, without coarser copies.
  [[nodiscard]] float step_mm() const { return levels_.front().step_mm; }
  [[nodiscard]] const TransferTable& table() const { return levels_.front().table; }

 private:
  /// The volume, or a coarser copy of it, and what of it is seen.
  struct Level {
    explicit Level(std::shared_ptr<const Volume> voxels);

    std::shared_ptr<const Volume> volume;
    VolumeBricks bricks;
    float step_mm;
    TransferTable table;
    std::vector<std::uint8_t> distances;
  };

  [[nodiscard]] const Level& level_for(const RayBundle& bundle) const;

  std::vector<Level> levels_;
  std::optional<VolumeView> view_;
};

}  // namespace mor::internal
