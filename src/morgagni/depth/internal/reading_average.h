// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/depth/internal/depth_grid.h"
#include "morgagni/geometry/depth_levels.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// Means of the readings around the points of a down-sampled grid. Each point has a box of the
/// picture as wide as the grid's spacing; a pixel on the border of two boxes counts in either by
/// its part there. So every reading weighs alike, which is what makes the most of them.
class ReadingAverage {
 public:
  /// @param down_sampling  The grid's spacing in pixels, >= 1.
  ReadingAverage(const PinholeCamera& camera, double down_sampling, int width, int height);

  /// Puts the points in the mask where the mean of their readings lies; one whose box leaves the
  /// picture stays. Readings of another surface than the point's own do not count.
  void put_at_means(ImageView<const std::uint16_t> depth_mm,
                    const DepthLevels& levels,
                    const std::vector<std::uint8_t>& mask,
                    DepthGrid& grid) const;

  /// The mean over a box of a curved surface lies inside the curve, all over a head by hundredths
  /// of a millimetre: takes this out, by the curvature between connected neighbours. The noise
  /// that this adds to a point is taken from its neighbours and cancels over the surface.
  void undo_flattening(const std::vector<std::uint8_t>& edges,
                       const std::vector<std::uint8_t>& mask,
                       DepthGrid& grid);

 private:
  /// A box along one side of the picture, about a whole or half pixel.
  struct Box {
    int nearest = 0;  ///< The pixel nearest to its middle.
    int first = 0;    ///< Pixel.
    int size = 1;     ///< Pixels.
    std::array<float, 5> weights{};
    /// Mean square distance of its readings from its middle, times half the curvature that
    /// neighbours' differences of 1 mm stand for.
    float flattening = 0.0F;
  };

  static std::vector<Box> boxes(double down_sampling, int count, int size_px);
  [[nodiscard]] float mean(ImageView<const std::uint16_t> depth_mm,
                           const DepthLevels& levels,
                           const Box& column,
                           const Box& row) const;

  std::vector<Box> columns_, rows_;  ///< Of no size where the box leaves the picture.
  std::vector<float> ray_x_, ray_y_;
  std::vector<float> mean_mm_;
};

}  // namespace mor::internal
