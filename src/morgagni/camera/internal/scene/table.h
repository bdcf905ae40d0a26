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
/// lowest point, level or in waves about it. Its picture, wood with the body's soft shadow, is
/// painted once.
class Table {
 public:
  /// @param uneven_mm  Root mean square of the waves, which are 400 to 1600 mm long.
  Table(const TriangleMesh& skin, std::uint64_t seed, double uneven_mm);

  [[nodiscard]] float top_mm() const { return top_mm_; }
  [[nodiscard]] float floor_mm() const { return top_mm_ + kHeightMm; }

  [[nodiscard]] bool is_level() const { return heights_mm_.empty(); }
  /// How far it lies above top_mm() at a place in its picture. @pre Not level; inside.
  [[nodiscard]] float height_mm(float column, float row) const;

  /// Column and row in the table's picture of a place (x, z) on its plane.
  [[nodiscard]] Eigen::Vector2f texel_at(float x_mm, float z_mm) const {
    return {(x_mm - left_mm_) * kTexelsPerMm, (z_mm - foot_mm_) * kTexelsPerMm};
  }
  [[nodiscard]] static constexpr float texels_per_mm() { return kTexelsPerMm; }
  /// Its size in texels, and the colours row by row.
  [[nodiscard]] ImageView<const Rgb8> picture() const { return picture_.view(); }

 private:
  static constexpr float kHeightMm = 780.0F;
  static constexpr float kTexelsPerMm = 0.8F;
  static constexpr float kTexelsANode = 16.0F;

  void bend(double uneven_mm, std::uint64_t seed);
  void paint_wood(std::uint64_t seed);
  void paint_shadow(const TriangleMesh& skin);

  float top_mm_ = 0.0F;
  float left_mm_ = 0.0F;
  float foot_mm_ = 0.0F;
  Image<Rgb8> picture_;
  Image<float> heights_mm_;  ///< A node every kTexelsANode texels; empty: level.
};

/// Smooth noise in [0, 1] that repeats every 256 units, from a lattice of seeded values.
[[nodiscard]] float smooth_noise(float x, float y, float z, std::uint64_t seed);

}  // namespace mor::internal
