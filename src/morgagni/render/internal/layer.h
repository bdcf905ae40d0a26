// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/render/internal/pixel_box.h"

namespace mor::internal {

/// Depth where a layer has nothing.
inline constexpr float kNoDepth = std::numeric_limits<float>::max();

/// A part of the picture with what is drawn there, and how far away it is: the one thing that
/// surfaces, slices and the hole's wall are made into, so that any of them can be before any other.
struct Layer {
  PixelBox box;
  std::vector<Rgba8> pixels;    ///< Row by row from the top, premultiplied by alpha.
  std::vector<float> depth_mm;  ///< z in the colour frame.

  /// Of this box, with nothing in it.
  void clear(const PixelBox& new_box) {
    box = new_box;
    const auto size = static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height);
    pixels.assign(size, Rgba8{0, 0, 0, 0});
    depth_mm.assign(size, kNoDepth);
  }

  [[nodiscard]] std::size_t row_start(int y) const {
    return static_cast<std::size_t>(y - box.top) * static_cast<std::size_t>(box.width);
  }
  [[nodiscard]] const Rgba8* row(int y) const { return pixels.data() + row_start(y); }
  [[nodiscard]] const float* depth_row(int y) const { return depth_mm.data() + row_start(y); }
};

}  // namespace mor::internal
