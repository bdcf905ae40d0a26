// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"

#include "messages.h"

namespace mor::import {

inline constexpr double kMaxGapMm = 15.0;  ///< Between two slices: wider ones are not bridged.

/// Parallel slices of one size, as a scanner made them: each at its own place.
struct SliceStack {
  int columns = 0;
  int rows = 0;
  Eigen::Vector2d spacing_mm;               ///< Along a row, down a column.
  Eigen::Matrix<double, 3, 2> axes;         ///< Unit vectors along a row, down a column, LPS.
  std::vector<Eigen::Vector3d> origins_mm;  ///< First pixel's centre; in order along the normal.
  std::vector<std::string> names;           ///< Of the slices, for people.

  [[nodiscard]] Eigen::Vector3d normal() const { return axes.col(0).cross(axes.col(1)); }
};

/// How far a stack is from a right-angled, even grid.
struct StackShape {
  double tilt_rad = 0.0;  ///< Between the line through the slices' origins and their normal.
  double min_gap_mm = 0.0;
  double max_gap_mm = 0.0;
};
[[nodiscard]] StackShape shape_of(const SliceStack& stack);

/// The slices after which the gap is half as wide again as both gaps beside it.
[[nodiscard]] std::vector<std::size_t> wide_gaps(const SliceStack& stack);

/// The grid that holds the whole stack: in-plane as the slices are, even along their normal.
/// @errors kUnsupported: two slices at one place, or a gap too wide to interpolate.
[[nodiscard]] Result<ImportHeader> grid_for(const SliceStack& stack);

/// Fills the grid from the slices: linear between the two nearest, each shifted in its plane by
/// where it really lies. Outside every slice it is air.
/// @param hu         The grid's voxels.
/// @param pixels_of  The HU of slice k, columns * rows, asked for in order, once each.
[[nodiscard]] Result<void> resample(
    const SliceStack& stack,
    const ImportHeader& grid,
    std::span<std::int16_t> hu,
    const std::function<Result<std::vector<std::int16_t>>(std::size_t)>& pixels_of);

}  // namespace mor::import
