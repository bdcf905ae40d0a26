// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/pixel_box.h"
#include "morgagni/render/internal/view_grid.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor::internal {

/// Hands and instruments before the body: where the depth camera sees something nearer than the CT
/// skin at its pose, the live picture stays as it is.
///
/// The readings are brought to the colour camera's view (the two cameras stand side by side), where
/// each cell of the grid takes the nearest one. A cell surely in front of the skin grows over those
/// that are in front by more than noise. The outline is then taken from the colour picture, which
/// is sharper and calmer than the depth picture's: a guided filter (He et al. 2010), each cell
/// weighted by whether it has a reading.
class Occluders {
 public:
  /// @return Whether anything is in front of the body within `box`.
  bool update(const MeasuredDepth& measured,
              const ViewGrid& grid,
              ImageView<const Rgb8> color,
              const PictureRays& color_rays,
              const PixelBox& box);

  /// Share of what is in front, 0..255, at the pixels from (left, y) on, in the last `box`.
  [[nodiscard]] const std::uint8_t* row(int y, int left) const {
    return shares_.data() + static_cast<std::size_t>(y - box_.top) * box_.width +
           (left - box_.left);
  }

 private:
  enum class Cell : std::uint8_t { kUnknown, kBody, kMaybe, kInFront };
  using Sums = float __attribute__((vector_size(32)));  // Eight; portable vectors of GCC and Clang.

  void take_nearest(const MeasuredDepth& measured, const ViewGrid& grid);
  [[nodiscard]] bool classify(const ViewGrid& grid);
  void grow_fronts();
  void fill_gaps();
  void fit_to_colors(ImageView<const Rgb8> color, const PictureRays& rays, const ViewGrid& grid);
  void spread(ImageView<const Rgb8> color, const PictureRays& rays, const ViewGrid& grid);

  PictureRays depth_rays_;
  PixelBox box_;
  int width_ = 0;
  int height_ = 0;
  std::vector<float> nearest_mm_;
  std::vector<Cell> cells_;
  std::vector<Sums> sums_;
  std::vector<Sums> scratch_;
  std::vector<std::uint32_t> front_;
  std::vector<std::uint8_t> shares_;
};

}  // namespace mor::internal
