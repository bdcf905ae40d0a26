// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace mor::internal {

/// What one place of a surface (SkinProfile) has over it.
struct SurfacePlace {
  float lifted_mm = 0.0F;  ///< Thickness of what has air beneath it; 0: nothing has.
  float light_mm = 0.0F;   ///< Of a light layer that lies on the skin.
  float most_hu = 0.0F;    ///< Of the layer.
  float outside_hu = 0.0F;
};

/// A sheet with air beneath it, as it is in the middle of its places.
struct LiftedSheet {
  float thick_mm = 0.0F;
  float most_hu = 0.0F;
  float outside_hu = 0.0F;
  bool is_even = false;   ///< As no ear is.
  double area_mm2 = 0.0;  ///< Of its places.
  std::vector<float> hu;  ///< From the crossing through it, step by step.
  std::vector<std::size_t> places;

  /// As many of `hu` are no deeper than its middle.
  [[nodiscard]] std::size_t num_outer() const;
};

}  // namespace mor::internal
