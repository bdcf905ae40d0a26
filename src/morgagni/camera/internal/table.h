// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The table under a supine body, frame ct (LPS): a plane of constant y that touches the skin's
/// lowest point. Its picture, wood with the body's soft shadow, is painted once.
class Table {
 public:
  Table(const TriangleMesh& skin, std::uint64_t seed);

  [[nodiscard]] float top_mm() const { return top_mm_; }
  [[nodiscard]] float floor_mm() const { return top_mm_ + kHeightMm; }

  /// Colour at (x, z) of the table's plane; null beyond its rim.
  [[nodiscard]] const Rgb8* color_at(float x_mm, float z_mm) const {
    const int column = static_cast<int>((x_mm - left_mm_) * kTexelsPerMm);
    const int row = static_cast<int>((z_mm - foot_mm_) * kTexelsPerMm);
    const bool is_on = x_mm >= left_mm_ && z_mm >= foot_mm_ && column < picture_.width() &&
                       row < picture_.height();
    return is_on ? &picture_(column, row) : nullptr;
  }

 private:
  static constexpr float kHeightMm = 780.0F;
  static constexpr float kTexelsPerMm = 0.8F;

  void paint_wood(std::uint64_t seed);
  void paint_shadow(const TriangleMesh& skin);

  float top_mm_ = 0.0F;
  float left_mm_ = 0.0F;
  float foot_mm_ = 0.0F;
  Image<Rgb8> picture_;
};

/// Smooth noise in [0, 1] that repeats every 256 units, from a lattice of seeded values.
[[nodiscard]] float smooth_noise(float x, float y, float z, std::uint64_t seed);

}  // namespace mor::internal
