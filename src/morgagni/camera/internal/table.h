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

  /// Where (x, z) of the table's plane lies in its picture; -1 beyond the rim. Without branches,
  /// for whole rows of pixels are asked for at once.
  [[nodiscard]] std::int32_t texel_at(float x_mm, float z_mm) const {
    const float column = (x_mm - left_mm_) * kTexelsPerMm;
    const float row = (z_mm - foot_mm_) * kTexelsPerMm;
    const auto width = static_cast<float>(picture_.width());
    const auto height = static_cast<float>(picture_.height());
    const bool is_on = (column >= 0.0F) & (row >= 0.0F) & (column < width) & (row < height);
    const auto whole_column = static_cast<std::int32_t>(is_on ? column : 0.0F);
    const auto whole_row = static_cast<std::int32_t>(is_on ? row : 0.0F);
    return is_on ? whole_row * picture_.width() + whole_column : -1;
  }
  [[nodiscard]] const Rgb8& texel(std::int32_t index) const { return picture_.data()[index]; }

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
