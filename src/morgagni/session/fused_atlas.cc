// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/fused_atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace mor {
namespace {

using Corners = std::array<Eigen::Vector2f, 3>;

float twice_area(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// Marks the texels whose centres lie in the triangle.
void mark(const Corners& corners, Image<std::uint8_t>& is_skin) {
  const auto& [a, b, c] = corners;
  const Eigen::Vector2f least = a.cwiseMin(b).cwiseMin(c);
  const Eigen::Vector2f most = a.cwiseMax(b).cwiseMax(c);
  const float sign = twice_area(a, b, c) < 0.0F ? -1.0F : 1.0F;
  const int bottom = std::min(is_skin.height() - 1, static_cast<int>(std::floor(most.y())));
  const int right = std::min(is_skin.width() - 1, static_cast<int>(std::floor(most.x())));
  for (int y = std::max(0, static_cast<int>(std::ceil(least.y()))); y <= bottom; ++y) {
    for (int x = std::max(0, static_cast<int>(std::ceil(least.x()))); x <= right; ++x) {
      const Eigen::Vector2f p(static_cast<float>(x), static_cast<float>(y));
      if (sign * twice_area(a, b, p) >= 0.0F && sign * twice_area(b, c, p) >= 0.0F &&
          sign * twice_area(c, a, p) >= 0.0F) {
        is_skin(x, y) = 1;
      }
    }
  }
}

/// Beside a triangle a texel is as seen as the skin next to it, so that no line of unseen skin is
/// drawn where the atlas is cut.
bool is_seen_nearby(const SkinTexture& texture, int x, int y) {
  const int bottom = std::min(texture.color.height() - 1, y + 1);
  const int right = std::min(texture.color.width() - 1, x + 1);
  for (int v = std::max(0, y - 1); v <= bottom; ++v) {
    for (int u = std::max(0, x - 1); u <= right; ++u) {
      if (texture.is_seen(u, v)) return true;
    }
  }
  return false;
}

}  // namespace

AtlasPicture FusedAtlas::picture(const std::shared_ptr<const SkinTexture>& texture) {
  if (texture == texture_) return picture_;
  texture_ = texture;
  if (texture->atlas != atlas_) {
    atlas_ = texture->atlas;
    take(*atlas_);
  }
  auto colors = std::make_shared<Image<Rgba8>>(texture->color.width(), texture->color.height());
  for (int y = 0; y < colors->height(); ++y) {
    for (int x = 0; x < colors->width(); ++x) {
      const Rgb8& color = texture->color(x, y);
      const bool is_seen =
          is_skin_(x, y) == 1 ? texture->is_seen(x, y) : is_seen_nearby(*texture, x, y);
      (*colors)(x, y) = {color.r, color.g, color.b, static_cast<std::uint8_t>(is_seen ? 255 : 0)};
    }
  }
  picture_.colors = std::move(colors);
  return picture_;
}

void FusedAtlas::take(const SkinAtlas& atlas) {
  auto surface = std::make_shared<AtlasSurface>();
  surface->mesh = atlas.mesh;
  surface->corners_px = atlas.corners_px;
  surface->width_px = atlas.width_px;
  surface->height_px = atlas.height_px;
  picture_.surface = std::move(surface);
  is_skin_ = Image<std::uint8_t>(atlas.width_px, atlas.height_px, 0);
  for (const auto& corners : atlas.corners_px) mark(corners, is_skin_);
}

}  // namespace mor
