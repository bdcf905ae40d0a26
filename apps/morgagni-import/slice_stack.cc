// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "slice_stack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "messages.h"

namespace mor::import {
namespace {

using Slice = std::vector<std::int16_t>;

constexpr std::int16_t kAirHu = -1024;
constexpr double kMinGapMm = 0.01;
constexpr double kLeastSpacingMm = 0.3;  ///< Of uneven slices: finer than any scanner's detector.
constexpr double kEvenGapRatio = 1.02;
constexpr double kNegligibleShiftPx = 0.05;

std::vector<double> heights_of(const SliceStack& stack) {
  std::vector<double> heights;
  for (const auto& origin : stack.origins_mm)
    heights.push_back(stack.normal().dot(origin - stack.origins_mm.front()));
  return heights;
}

/// Where slice k lies in its plane, relative to the first, in mm.
Eigen::Vector2d offset_mm(const SliceStack& stack, std::size_t k) {
  return stack.axes.transpose() * (stack.origins_mm[k] - stack.origins_mm.front());
}

Eigen::AlignedBox2d offsets_of(const SliceStack& stack) {
  Eigen::AlignedBox2d box(Eigen::Vector2d::Zero());
  for (std::size_t k = 0; k < stack.origins_mm.size(); ++k) box.extend(offset_mm(stack, k));
  return box;
}

bool is_straight(const SliceStack& stack) {
  const Eigen::Vector2d range_px = offsets_of(stack).sizes().cwiseQuotient(stack.spacing_mm);
  return range_px.maxCoeff() < kNegligibleShiftPx;
}

bool is_even(const StackShape& shape) {
  return shape.max_gap_mm <= shape.min_gap_mm * kEvenGapRatio;
}

/// The slice moved by `shift_px` onto the wider grid, bilinear.
Slice shifted(const Slice& slice,
              int columns,
              int rows,
              const Eigen::Vector2d& shift_px,
              int grid_columns,
              int grid_rows) {
  const int dx = static_cast<int>(std::floor(shift_px.x()));
  const int dy = static_cast<int>(std::floor(shift_px.y()));
  const auto fx = static_cast<float>(shift_px.x() - dx);
  const auto fy = static_cast<float>(shift_px.y() - dy);
  const auto at = [&](int x, int y) {
    const bool inside = x >= 0 && y >= 0 && x < columns && y < rows;
    return inside ? static_cast<float>(slice[static_cast<std::size_t>(y) * columns + x])
                  : static_cast<float>(kAirHu);
  };
  Slice result(static_cast<std::size_t>(grid_columns) * grid_rows);
  for (int y = 0; y < grid_rows; ++y) {
    for (int x = 0; x < grid_columns; ++x) {
      const int sx = x - dx;
      const int sy = y - dy;
      const float low = at(sx, sy - 1) * fy + at(sx, sy) * (1.0F - fy);
      const float left = at(sx - 1, sy - 1) * fy + at(sx - 1, sy) * (1.0F - fy);
      result[static_cast<std::size_t>(y) * grid_columns + x] =
          static_cast<std::int16_t>(std::lround(left * fx + low * (1.0F - fx)));
    }
  }
  return result;
}

Result<void> check_gaps(const SliceStack& stack) {
  const auto heights = heights_of(stack);
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
    const double gap_mm = heights[k + 1] - heights[k];
    const std::string pair = stack.names[k] + " and " + stack.names[k + 1];
    if (gap_mm < kMinGapMm) {
      return make_error(ErrorCode::kUnsupported,
                        "two slices lie at the same place and differ (" + pair +
                            "): the series has several phases; keep one");
    }
    if (gap_mm > kMaxGapMm) {
      return make_error(ErrorCode::kUnsupported,
                        "two neighbouring slices lie " + short_text(gap_mm) + " mm apart (" + pair +
                            "), more than " + short_text(kMaxGapMm) +
                            " mm is not bridged: slices are missing");
    }
  }
  return {};
}

Result<void> check_limits(const std::array<double, 3>& sides) {
  const double num_bytes = 2.0 * sides[0] * sides[1] * sides[2];
  if (std::all_of(sides.begin(), sides.end(), [](double side) { return side <= kMaxVolumeSide; }) &&
      num_bytes <= static_cast<double>(kMaxVolumeBytes))
    return {};
  return make_error(ErrorCode::kInvalidArgument,
                    "the CT would have " + short_text(sides[0]) + " x " + short_text(sides[1]) +
                        " x " + short_text(sides[2]) + " voxels, the limits are " +
                        std::to_string(kMaxVolumeSide) + " a side and " +
                        std::to_string(kMaxVolumeBytes >> 20) + " MiB");
}

}  // namespace

StackShape shape_of(const SliceStack& stack) {
  const auto heights = heights_of(stack);
  StackShape shape;
  shape.min_gap_mm = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < heights.size(); ++k) {
    shape.min_gap_mm = std::min(shape.min_gap_mm, heights[k] - heights[k - 1]);
    shape.max_gap_mm = std::max(shape.max_gap_mm, heights[k] - heights[k - 1]);
  }
  const double sideways_mm = offset_mm(stack, heights.size() - 1).norm();
  shape.tilt_rad = std::atan2(sideways_mm, heights.back());
  return shape;
}

std::vector<std::size_t> wide_gaps(const SliceStack& stack) {
  constexpr double kWide = 1.5;
  const auto heights = heights_of(stack);
  std::vector<std::size_t> wide;
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
    const double gap_mm = heights[k + 1] - heights[k];
    double beside_mm = 0.0;
    if (k > 0) beside_mm = heights[k] - heights[k - 1];
    if (k + 2 < heights.size()) beside_mm = std::max(beside_mm, heights[k + 2] - heights[k + 1]);
    if (gap_mm > kWide * beside_mm) wide.push_back(k);
  }
  return wide;
}

Result<ImportHeader> grid_for(const SliceStack& stack) {
  const StackShape shape = shape_of(stack);
  MOR_CHECK(check_gaps(stack));
  const auto heights = heights_of(stack);
  const auto num_gaps = static_cast<double>(heights.size() - 1);
  const double spacing_z_mm =
      is_even(shape) ? heights.back() / num_gaps : std::max(shape.min_gap_mm, kLeastSpacingMm);
  const Eigen::AlignedBox2d offsets = offsets_of(stack);
  Eigen::Vector2d extra_px = Eigen::Vector2d::Zero();
  if (!is_straight(stack)) extra_px = offsets.sizes().cwiseQuotient(stack.spacing_mm);

  ImportHeader grid;
  grid.magic = kImportMagic;
  const std::array<double, 3> sides = {stack.columns + std::ceil(extra_px.x()),
                                       stack.rows + std::ceil(extra_px.y()),
                                       std::floor(heights.back() / spacing_z_mm + 1e-6) + 1.0};
  MOR_CHECK(check_limits(sides));
  std::transform(sides.begin(), sides.end(), grid.size.begin(), [](double side) {
    return static_cast<std::int32_t>(side);
  });
  grid.spacing_mm = {stack.spacing_mm.x(), stack.spacing_mm.y(), spacing_z_mm};
  const Eigen::Vector3d origin = stack.origins_mm.front() + stack.axes * offsets.min();
  std::copy_n(origin.data(), 3, grid.origin_mm.begin());
  std::copy_n(stack.axes.data(), 6, grid.axes.begin());
  const Eigen::Vector3d normal = stack.normal();
  std::copy_n(normal.data(), 3, grid.axes.begin() + 6);
  return grid;
}

Result<void> resample(
    const SliceStack& stack,
    const ImportHeader& grid,
    std::span<std::int16_t> hu,
    const std::function<Result<std::vector<std::int16_t>>(std::size_t)>& pixels_of) {
  const auto heights = heights_of(stack);
  const bool straight = is_straight(stack);
  const Eigen::Vector2d least = offsets_of(stack).min();
  const auto on_grid = [&](std::size_t k) -> Result<Slice> {
    MOR_TRY(Slice pixels, pixels_of(k));
    if (straight) return pixels;
    const Eigen::Vector2d shift_px = (offset_mm(stack, k) - least).cwiseQuotient(stack.spacing_mm);
    return shifted(pixels, stack.columns, stack.rows, shift_px, grid.size[0], grid.size[1]);
  };

  const std::size_t slice_voxels = static_cast<std::size_t>(grid.size[0]) * grid.size[1];
  MOR_TRY(Slice below, on_grid(0));
  MOR_TRY(Slice above, on_grid(1));
  std::size_t k = 0;
  const bool even = is_even(shape_of(stack));
  for (int z = 0; z < grid.size[2]; ++z) {
    const double height = z * grid.spacing_mm[2];
    while (k + 2 < heights.size() && (even ? z > static_cast<int>(k) : height > heights[k + 1])) {
      ++k;
      below = std::move(above);
      MOR_TRY(above, on_grid(k + 1));
    }
    // An even stack is taken as it is: no voxel is blurred by a rounding of the slices' places.
    const double exact = (height - heights[k]) / (heights[k + 1] - heights[k]);
    const auto share =
        static_cast<float>(even ? z - static_cast<int>(k) : std::clamp(exact, 0.0, 1.0));
    const auto slice = hu.subspan(static_cast<std::size_t>(z) * slice_voxels, slice_voxels);
    if (share == 0.0F) {
      std::copy(below.begin(), below.end(), slice.begin());
    } else if (share == 1.0F) {
      std::copy(above.begin(), above.end(), slice.begin());
    } else {
      for (std::size_t i = 0; i < slice_voxels; ++i)
        slice[i] = static_cast<std::int16_t>(std::lround(
            static_cast<float>(below[i]) + share * static_cast<float>(above[i] - below[i])));
    }
  }
  return {};
}

}  // namespace mor::import
