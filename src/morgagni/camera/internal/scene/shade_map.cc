// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/shade_map.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

using Eigen::Vector3f;

constexpr float kReachMm = 160.0F;  ///< A thing higher than this above a place casts no shadow.
constexpr float kNothingMm = 6.0F;  ///< Nor does the place itself.
constexpr float kDarkest = 0.5F;
constexpr int kBlurCells = 2;
constexpr int kRimCells = 3 * kBlurCells + 1;

/// One pass of a box over the cells, along a direction.
void blur(Image<float>& image, int step_x, int step_y) {
  Image<float> result(image.width(), image.height(), 0.0F);
  for (int y = kBlurCells * step_y; y < image.height() - kBlurCells * step_y; ++y) {
    for (int x = kBlurCells * step_x; x < image.width() - kBlurCells * step_x; ++x) {
      float sum = 0.0F;
      for (int i = -kBlurCells; i <= kBlurCells; ++i) sum += image(x + i * step_x, y + i * step_y);
      result(x, y) = sum / (2 * kBlurCells + 1);
    }
  }
  image = std::move(result);
}

}  // namespace

ShadeMap::ShadeMap(const TriangleMesh& things) {
  if (things.vertices.empty()) return;
  const auto bounds = things.bounds();
  const float rim_mm = kRimCells * kCellMm;
  corner_mm_ = {bounds.min().x() - rim_mm, bounds.min().z() - rim_mm};
  const int width = static_cast<int>(bounds.sizes().x() / kCellMm) + 2 * kRimCells + 2;
  const int height = static_cast<int>(bounds.sizes().z() / kCellMm) + 2 * kRimCells + 2;
  cover_ = Image<float>(width, height, 0.0F);
  height_mm_ = Image<float>(width, height, 0.0F);
  for (const auto& p : things.vertices) {
    const int x = static_cast<int>((p.x() - corner_mm_.x()) / kCellMm);
    const int z = static_cast<int>((p.z() - corner_mm_.y()) / kCellMm);
    height_mm_(x, z) = cover_(x, z) > 0.0F ? std::min(height_mm_(x, z), -p.y()) : -p.y();
    cover_(x, z) = 1.0F;
  }
  for (int pass = 0; pass < 2; ++pass) {
    for (auto* image : {&cover_, &height_mm_}) {
      blur(*image, 1, 0);
      blur(*image, 0, 1);
    }
  }
}

float ShadeMap::light_below_things(const Vector3f& at) const {
  const float x = (at.x() - corner_mm_.x()) / kCellMm - 0.5F;
  const float z = (at.z() - corner_mm_.y()) / kCellMm - 0.5F;
  if (!(x >= 0.0F && z >= 0.0F)) return 1.0F;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(z);
  if (!cover_.view().contains(column + 1, row + 1)) return 1.0F;
  const auto between = [&](const Image<float>& image) {
    const float tx = x - static_cast<float>(column);
    const float tz = z - static_cast<float>(row);
    return std::lerp(std::lerp(image(column, row), image(column + 1, row), tx),
                     std::lerp(image(column, row + 1), image(column + 1, row + 1), tx),
                     tz);
  };
  const float cover = between(cover_);
  if (cover < 0.01F) return 1.0F;
  const float above_mm = between(height_mm_) / cover + at.y();
  if (above_mm < -kNothingMm || above_mm > kReachMm) return 1.0F;
  // Fades in over the first millimetres, or a thing would shade its own top.
  const float begins = std::clamp((above_mm + kNothingMm) / (2.0F * kNothingMm), 0.0F, 1.0F);
  const float fades = 1.0F - std::max(above_mm, 0.0F) / kReachMm;
  return 1.0F - kDarkest * std::min(1.0F, 1.2F * cover) * begins * fades;
}

}  // namespace mor::internal
