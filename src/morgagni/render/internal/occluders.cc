// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/occluders.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mor::internal {
namespace {

/// In front of the skin by so much: surely, or maybe. A fingertip on the skin is 15 mm thick.
constexpr float kSurelyMm = 15.0F;
constexpr float kMaybeMm = 6.0F;
/// Three sigma of a Kinect's depth at 1 mm; it grows with the square of the distance.
constexpr float kNoisePerMm = 3.0F * 1.425e-6F;
constexpr int kLeastFriends = 4;  ///< Of the nine cells around and at one that is surely in front.
constexpr int kWidestGapCells = 24;  ///< Without a reading between two that are in front.
constexpr int kFilterCells = 3;      ///< Reach of the filter.
constexpr float kSameColor = 9.0F;   ///< Of 255: smaller steps of brightness are no outline.
constexpr float kLeastWeight = 1e-3F;
/// The filter's share at which the outline begins and is complete.
constexpr float kOutlineFrom = 0.25F;
constexpr float kOutlineTo = 0.60F;
constexpr float kNothing = std::numeric_limits<float>::max();

float brightness(const Rgb8& pixel) {
  return 0.299F * pixel.r + 0.587F * pixel.g + 0.114F * pixel.b;
}

/// Sums over a window of 2 * kFilterCells + 1 along a line of `count` values `step` apart.
template <class T>
void sum_line(const T* from, T* to, int count, std::ptrdiff_t step) {
  T sum{};
  for (int i = 0; i < std::min(kFilterCells, count); ++i) sum += from[i * step];
  for (int i = 0; i < count; ++i) {
    if (i + kFilterCells < count) sum += from[(i + kFilterCells) * step];
    if (i - kFilterCells > 0) sum -= from[(i - kFilterCells - 1) * step];
    to[i * step] = sum;
  }
}

template <class T>
void sum_windows(std::vector<T>& values, std::vector<T>& scratch, int width, int height) {
  scratch.resize(values.size());
  for (int y = 0; y < height; ++y) {
    const auto start = static_cast<std::size_t>(y) * width;
    sum_line(values.data() + start, scratch.data() + start, width, 1);
  }
  for (int x = 0; x < width; ++x) sum_line(scratch.data() + x, values.data() + x, height, width);
}

}  // namespace

bool Occluders::update(const MeasuredDepth& measured,
                       const ViewGrid& grid,
                       ImageView<const Rgb8> color,
                       const PictureRays& color_rays,
                       const PixelBox& box) {
  box_ = box;
  width_ = grid.width();
  height_ = grid.height();
  take_nearest(measured, grid);
  if (!classify(grid)) return false;
  grow_fronts();
  fill_gaps();
  fit_to_colors(color, color_rays, grid);
  spread(color, color_rays, grid);
  return true;
}

void Occluders::take_nearest(const MeasuredDepth& measured, const ViewGrid& grid) {
  depth_rays_.update(measured.depth_camera);
  const Eigen::Matrix3f rotation = measured.color_from_depth.linear().cast<float>();
  const Eigen::Vector3f translation = measured.color_from_depth.translation().cast<float>();
  nearest_mm_.assign(static_cast<std::size_t>(width_) * height_, kNothing);
  // Every second pixel, as on a chess board: a cell still gets two of them.
  const bool skip = measured.depth_mm.width() > width_;
  for (int y = 0; y < measured.depth_mm.height(); ++y) {
    const std::uint16_t* depth = measured.depth_mm.row(y);
    const Eigen::Vector2f* rays = depth_rays_.row(y);
    for (int x = skip ? y % 2 : 0; x < measured.depth_mm.width(); x += skip ? 2 : 1) {
      if (depth[x] == 0) continue;
      const Eigen::Vector3f point =
          rotation * (Eigen::Vector3f(rays[x].x(), rays[x].y(), 1.0F) * depth[x]) + translation;
      if (!(point.z() > 1.0F)) continue;
      const Eigen::Vector2f cell = grid.cell_of(point.head<2>() / point.z());
      const int column = static_cast<int>(cell.x() + 0.5F);
      const int row = static_cast<int>(cell.y() + 0.5F);
      if (cell.x() < 0.0F || cell.y() < 0.0F || column >= width_ || row >= height_) continue;
      float& nearest = nearest_mm_[static_cast<std::size_t>(row) * width_ + column];
      nearest = std::min(nearest, point.z());
    }
  }
}

bool Occluders::classify(const ViewGrid& grid) {
  cells_.assign(nearest_mm_.size(), Cell::kUnknown);
  bool is_any_in_front = false;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const float z = nearest_mm_[i];
    const float skin = grid.skin_mm().data()[i];
    if (z == kNothing || skin <= 0.0F) continue;
    const float in_front = skin - z - kNoisePerMm * z * z;
    cells_[i] = in_front > kSurelyMm  ? Cell::kInFront
                : in_front > kMaybeMm ? Cell::kMaybe
                                      : Cell::kBody;
    is_any_in_front |= in_front > kSurelyMm;
  }
  return is_any_in_front;
}

/// Fronts that stand alone are noise; the others take the cells beside them that may be in front.
void Occluders::grow_fronts() {
  front_.clear();
  for (int y = 1; y + 1 < height_; ++y) {
    for (int x = 1; x + 1 < width_; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * width_ + x;
      if (cells_[i] != Cell::kInFront) continue;
      int num_friends = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          num_friends += cells_[i + static_cast<std::size_t>(dy * width_ + dx)] == Cell::kInFront;
        }
      }
      if (num_friends >= kLeastFriends) front_.push_back(static_cast<std::uint32_t>(i));
    }
  }
  for (Cell& cell : cells_) {
    if (cell == Cell::kInFront) cell = Cell::kMaybe;
  }
  for (const std::uint32_t i : front_) cells_[i] = Cell::kInFront;
  const auto width = static_cast<std::uint32_t>(width_);
  while (!front_.empty()) {
    const std::uint32_t i = front_.back();
    front_.pop_back();
    for (const std::uint32_t next : {i - 1, i + 1, i - width, i + width}) {
      const std::uint32_t x = next % width;
      const std::uint32_t y = next / width;
      const bool is_inner = x > 0 && y > 0 && x + 1 < width && y + 1 < unsigned(height_);
      if (!is_inner || cells_[next] != Cell::kMaybe) continue;
      cells_[next] = Cell::kInFront;
      front_.push_back(next);
    }
  }
}

/// Shining metal gives no reading: a gap between two fronts of a row or column is front too. The
/// shadow that a hand throws on the depth picture has the body on its other side and stays unknown.
void Occluders::fill_gaps() {
  const auto fill_line = [&](std::size_t first, int count, std::size_t step) {
    int last_front = -1;
    for (int i = 0; i < count; ++i) {
      const Cell cell = cells_[first + i * step];
      if (cell == Cell::kUnknown) continue;
      if (cell == Cell::kInFront && last_front >= 0 && i - last_front <= kWidestGapCells) {
        for (int gap = last_front + 1; gap < i; ++gap) cells_[first + gap * step] = Cell::kInFront;
      }
      last_front = cell == Cell::kInFront ? i : -1;
    }
  };
  for (int y = 0; y < height_; ++y) fill_line(static_cast<std::size_t>(y) * width_, width_, 1);
  for (int x = 0; x < width_; ++x) fill_line(static_cast<std::size_t>(x), height_, width_);
}

/// Per cell the line share = a * brightness + b that fits its window best, mean of all that hold
/// the cell. Leaves a in lane 0 and b in lane 1 of `sums_`.
void Occluders::fit_to_colors(ImageView<const Rgb8> color,
                              const PictureRays& rays,
                              const ViewGrid& grid) {
  sums_.assign(cells_.size(), Sums{});
  const int reach = 4 * kFilterCells * std::max(2, color.width() / width_);
  const int bottom = std::min(color.height(), box_.top + box_.height + reach);
  const int right = std::min(color.width(), box_.left + box_.width + reach);
  for (int y = std::max(0, box_.top - reach); y < bottom; ++y) {
    for (int x = std::max(0, box_.left - reach); x < right; ++x) {
      const Eigen::Vector2f place = grid.cell_of(rays.row(y)[x]) + Eigen::Vector2f(0.5F, 0.5F);
      if (place.x() < 0.0F || place.y() < 0.0F) continue;
      const auto column = static_cast<int>(place.x());
      const auto row = static_cast<int>(place.y());
      if (column >= width_ || row >= height_) continue;
      Sums& sums = sums_[static_cast<std::size_t>(row) * width_ + column];
      sums[0] += brightness(color(x, y));
      sums[1] += 1.0F;
    }
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Sums& sums = sums_[i];
    if (cells_[i] == Cell::kUnknown || sums[1] == 0.0F) {
      sums = Sums{};
      continue;
    }
    const float light = sums[0] / sums[1];
    const float share = cells_[i] == Cell::kInFront ? 1.0F : 0.0F;
    sums = Sums{1.0F, light, share, light * light, light * share};
  }
  sum_windows(sums_, scratch_, width_, height_);
  for (Sums& sums : sums_) {
    const float weight = sums[0];
    if (weight < kLeastWeight) {
      sums = Sums{};
      continue;
    }
    const Sums mean = sums / weight;
    const float variance = mean[3] - mean[1] * mean[1];
    const float slope = (mean[4] - mean[1] * mean[2]) / (variance + kSameColor * kSameColor);
    sums = Sums{slope, mean[2] - slope * mean[1], 1.0F} * weight;
    sums[2] = weight;
  }
  sum_windows(sums_, scratch_, width_, height_);
  for (Sums& sums : sums_) sums = sums[2] < kLeastWeight ? Sums{} : sums / sums[2];
}

/// The cells' lines at the brightness of each pixel of the box.
void Occluders::spread(ImageView<const Rgb8> color, const PictureRays& rays, const ViewGrid& grid) {
  shares_.resize(static_cast<std::size_t>(box_.width) * box_.height);
  std::uint8_t* share = shares_.data();
  for (int y = box_.top; y < box_.top + box_.height; ++y) {
    for (int x = box_.left; x < box_.left + box_.width; ++x, ++share) {
      const Eigen::Vector2f place = grid.cell_of(rays.row(y)[x]);
      const float u = std::clamp(place.x(), 0.0F, static_cast<float>(width_ - 1));
      const float v = std::clamp(place.y(), 0.0F, static_cast<float>(height_ - 1));
      const int column = std::min(static_cast<int>(u), std::max(width_ - 2, 0));
      const int row = std::min(static_cast<int>(v), std::max(height_ - 2, 0));
      const int next_column = std::min(column + 1, width_ - 1);
      const int next_row = std::min(row + 1, height_ - 1);
      const float right = u - static_cast<float>(column);
      const float down = v - static_cast<float>(row);
      const Sums* upper = sums_.data() + static_cast<std::size_t>(row) * width_;
      const Sums* lower = sums_.data() + static_cast<std::size_t>(next_row) * width_;
      const Sums line =
          (upper[column] * (1.0F - right) + upper[next_column] * right) * (1.0F - down) +
          (lower[column] * (1.0F - right) + lower[next_column] * right) * down;
      const float raw = line[0] * brightness(color(x, y)) + line[1];
      const float t = std::clamp((raw - kOutlineFrom) / (kOutlineTo - kOutlineFrom), 0.0F, 1.0F);
      *share = static_cast<std::uint8_t>(std::lround(255.0F * t * t * (3.0F - 2.0F * t)));
    }
  }
}

}  // namespace mor::internal
