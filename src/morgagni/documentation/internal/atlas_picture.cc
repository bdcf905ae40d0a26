// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/atlas_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "morgagni/documentation/export_model.h"

namespace mor::internal {
namespace {

constexpr int kRimPx = 6;  ///< How far a patch's colours go on. Between patches there is less.

float cross(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Marks the texels whose centre lies in the triangle or on its edge.
void mark_triangle(const std::array<Eigen::Vector2f, 3>& corners, Image<std::uint8_t>& is_skin) {
  Eigen::AlignedBox2f box(corners[0]);
  box.extend(corners[1]).extend(corners[2]);
  const float area = cross(corners[1] - corners[0], corners[2] - corners[0]);
  if (area == 0.0F) return;
  const float tolerance = -1e-4F;
  const int last_x = std::min(static_cast<int>(std::floor(box.max().x())), is_skin.width() - 1);
  const int last_y = std::min(static_cast<int>(std::floor(box.max().y())), is_skin.height() - 1);
  for (int y = std::max(0, static_cast<int>(std::ceil(box.min().y()))); y <= last_y; ++y) {
    for (int x = std::max(0, static_cast<int>(std::ceil(box.min().x()))); x <= last_x; ++x) {
      const Eigen::Vector2f p(static_cast<float>(x), static_cast<float>(y));
      const float u = cross(corners[1] - corners[0], p - corners[0]) / area;
      const float v = cross(p - corners[0], corners[2] - corners[0]) / area;
      if (u >= tolerance && v >= tolerance && u + v <= 1.0F - tolerance) is_skin(x, y) = 1;
    }
  }
}

/// Each texel beside a known one takes its neighbours' mean; one ring of texels a call.
void grow_rim(Image<Rgb8>& picture, Image<std::uint8_t>& is_known) {
  std::vector<std::pair<std::pair<int, int>, Rgb8>> ring;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      if (is_known(x, y) != 0) continue;
      int count = 0;
      std::array<int, 3> sum{};
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!is_known.view().contains(x + dx, y + dy) || is_known(x + dx, y + dy) == 0) continue;
          const Rgb8 color = picture(x + dx, y + dy);
          sum = {sum[0] + color.r, sum[1] + color.g, sum[2] + color.b};
          ++count;
        }
      }
      if (count == 0) continue;
      const auto mean = [&](int channel) { return static_cast<std::uint8_t>(channel / count); };
      ring.push_back({{x, y}, Rgb8{mean(sum[0]), mean(sum[1]), mean(sum[2])}});
    }
  }
  for (const auto& [place, color] : ring) {
    picture(place.first, place.second) = color;
    is_known(place.first, place.second) = 1;
  }
}

}  // namespace

AtlasPicture paint_atlas(const SkinTexture& texture) {
  AtlasPicture result{texture.color};
  Image<std::uint8_t> is_skin(texture.color.width(), texture.color.height(), 0);
  for (const auto& corners : texture.atlas->corners_px) mark_triangle(corners, is_skin);
  std::size_t num_skin = 0;
  std::size_t num_seen = 0;
  for (int y = 0; y < is_skin.height(); ++y) {
    for (int x = 0; x < is_skin.width(); ++x) {
      const bool is_seen = is_skin(x, y) != 0 && texture.is_seen(x, y);
      num_skin += is_skin(x, y);
      num_seen += is_seen ? 1 : 0;
      if (!is_seen) result.picture(x, y) = kNeverSeenColor;
    }
  }
  for (int ring = 0; ring < kRimPx; ++ring) grow_rim(result.picture, is_skin);
  if (num_skin > 0)
    result.seen_share = static_cast<double>(num_seen) / static_cast<double>(num_skin);
  return result;
}

}  // namespace mor::internal
