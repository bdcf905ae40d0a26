// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/ray_bundle.h"
#include "morgagni/render/internal/transfer_table.h"
#include "morgagni/render/internal/volume_bricks.h"

namespace mor::internal {

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

  /// The volume, or a coarser copy of it, and what of it is seen.
  struct Level {
    explicit Level(std::shared_ptr<const Volume> voxels);

    std::shared_ptr<const Volume> volume;
    VolumeBricks bricks;
    float step_mm;
    TransferTable table;
    std::vector<std::uint8_t> distances;  ///< Of bricks to what is seen; four bytes more.
  };

  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  /// Number of the one that has the voxels for these rays.
  [[nodiscard]] std::size_t level_for(const RayBundle& bundle) const;
  /// Counts what set() changed.
  [[nodiscard]] int revision() const { return revision_; }

  /// Of the volume as it is, without coarser copies.
  [[nodiscard]] float step_mm() const { return levels_.front().step_mm; }
  [[nodiscard]] const TransferTable& table() const { return levels_.front().table; }

 private:
  std::vector<Level> levels_;
  std::optional<VolumeView> view_;
  int revision_ = 0;
};

}  // namespace mor::internal
