// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/depth/internal/reading_average.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

/// Readings farther apart in depth are not averaged.
constexpr float kSameSurfaceMm = 12.0F;

double middle_px(double down_sampling, int i) {
  return std::round(2.0 * i * down_sampling) / 2.0;
}

}  // namespace

ReadingAverage::ReadingAverage(const PinholeCamera& camera,
                               double down_sampling,
                               int width,
                               int height)
    : columns_(boxes(down_sampling, width, camera.width_px)),
      rows_(boxes(down_sampling, height, camera.height_px)) {
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d ray =
          camera.ray(Eigen::Vector2d(middle_px(down_sampling, x), middle_px(down_sampling, y)));
      ray_x_.push_back(static_cast<float>(ray.x()));
      ray_y_.push_back(static_cast<float>(ray.y()));
    }
  }
}

std::vector<ReadingAverage::Box> ReadingAverage::boxes(double down_sampling,
                                                       int count,
                                                       int size_px) {
  constexpr double kTouches = 1e-9;
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const double middle = middle_px(down_sampling, i);
    const double begin = middle - down_sampling / 2.0;
    const double end = middle + down_sampling / 2.0;
    const int first = static_cast<int>(std::floor(begin + 0.5 + kTouches));
    const int last = static_cast<int>(std::ceil(end - 0.5 - kTouches));
    Box box{.nearest = static_cast<int>(std::lround(i * down_sampling)), .first = first};
    box.size = first >= 0 && last < size_px ? last - first + 1 : 0;
    double spread_px2 = 0.0;
    for (int k = 0; k < box.size; ++k) {
      const double pixel = first + k;
      const double weight = std::min(end, pixel + 0.5) - std::max(begin, pixel - 0.5);
      box.weights[static_cast<std::size_t>(k)] = static_cast<float>(weight);
      spread_px2 += weight / down_sampling * (pixel - middle) * (pixel - middle);
    }
    box.flattening = static_cast<float>(0.5 * spread_px2 / (down_sampling * down_sampling));
    boxes.push_back(box);
  }
  return boxes;
}

/// Readings come in pairs on either side of the middle, so that a slope moves nothing; a pair
/// counts where both are of the surface. 0 where none does.
float ReadingAverage::mean(ImageView<const std::uint16_t> depth_mm,
                           const DepthLevels& levels,
                           const Box& column,
                           const Box& row) const {
  const float own_mm = levels.mm(depth_mm(column.nearest, row.nearest));
  float sum_mm = 0.0F;
  float sum_weights = 0.0F;
  // Of the middle row, if there is one, each pair is seen twice: half of it each time.
  for (int v = 0; v < (row.size + 1) / 2; ++v) {
    const std::uint16_t* above = depth_mm.row(row.first + v) + column.first;
    const int mirrored = row.size - 1 - v;
    const std::uint16_t* below = depth_mm.row(row.first + mirrored) + column.first;
    const float row_weight =
        row.weights[static_cast<std::size_t>(v)] * (mirrored == v ? 0.5F : 1.0F);
    for (int u = 0; u < column.size; ++u) {
      const float one_mm = levels.mm(above[u]);
      const float other_mm = levels.mm(below[column.size - 1 - u]);
      const bool same = std::abs(one_mm - own_mm) <= kSameSurfaceMm &&
                        std::abs(other_mm - own_mm) <= kSameSurfaceMm;
      const float weight = same ? row_weight * column.weights[static_cast<std::size_t>(u)] : 0.0F;
      sum_mm += weight * (one_mm + other_mm);
      sum_weights += 2.0F * weight;
    }
  }
  return sum_weights > 0.0F ? sum_mm / sum_weights : 0.0F;
}

void ReadingAverage::put_at_means(ImageView<const std::uint16_t> depth_mm,
                                  const DepthLevels& levels,
                                  const std::vector<std::uint8_t>& mask,
                                  DepthGrid& grid) const {
  std::size_t i = 0;
  for (const Box& row : rows_) {
    for (const Box& column : columns_) {
      const std::size_t point = i++;
      if (mask[point] == 0 || row.size == 0 || column.size == 0) continue;
      const float mean_mm = mean(depth_mm, levels, column, row);
      if (mean_mm == 0.0F) continue;
      grid.z[point] = mean_mm;
      grid.x[point] = ray_x_[point] * mean_mm;
      grid.y[point] = ray_y_[point] * mean_mm;
    }
  }
}

void ReadingAverage::undo_flattening(const std::vector<std::uint8_t>& edges,
                                     const std::vector<std::uint8_t>& mask,
                                     DepthGrid& grid) {
  mean_mm_ = grid.z;
  const std::size_t width = columns_.size();
  const auto bend_mm = [this](std::size_t i, std::size_t step) {
    const float before_mm = mean_mm_[i - step] - mean_mm_[i];
    const float after_mm = mean_mm_[i + step] - mean_mm_[i];
    const bool same = std::abs(before_mm) <= kSameSurfaceMm && std::abs(after_mm) <= kSameSurfaceMm;
    return same ? before_mm + after_mm : 0.0F;
  };
  for (std::size_t y = 1; y + 1 < rows_.size(); ++y) {
    for (std::size_t x = 1; x + 1 < width; ++x) {
      const std::size_t i = y * width + x;
      if (mask[i] == 0) continue;
      float flattening_mm = 0.0F;
      if ((edges[i] & edges[i - 1] & kRight) != 0) {
        flattening_mm += columns_[x].flattening * bend_mm(i, 1);
      }
      if ((edges[i] & edges[i - width] & kDown) != 0) {
        flattening_mm += rows_[y].flattening * bend_mm(i, width);
      }
      const float z_mm = mean_mm_[i] - flattening_mm;
      grid.x[i] *= z_mm / mean_mm_[i];
      grid.y[i] *= z_mm / mean_mm_[i];
      grid.z[i] = z_mm;
    }
  }
}

}  // namespace mor::internal
