// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/composition.h"

#include <algorithm>
#include <cmath>

#include <libyuv/convert_argb.h>
#include <tbb/parallel_for.h>

#include "morgagni/render/internal/fragments.h"

namespace mor::internal {
namespace {

constexpr float kEverywhereRadius = 2.0F;
constexpr float kDarkening = 0.50F;     ///< Of the picture in the hole at opacity 1.
constexpr float kRimDarkening = 0.74F;  ///< At its rim, as if the hole had a wall.
constexpr float kWallWidth = 2.5F;      ///< Times the rim's width.
constexpr float kRingHalfWidthPx = 1.3F;
constexpr float kRingStrength = 0.55F;

/// Exactly a * b / 255, rounded, for a, b in 0..255.
constexpr unsigned share(unsigned a, unsigned b) {
  const unsigned t = a * b + 128U;
  return (t + (t >> 8U)) >> 8U;
}

float smooth_step(float low, float high, float value) {
  if (high <= low) return value < low ? 0.0F : 1.0F;
  const float t = std::clamp((value - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

std::uint8_t to_byte(float share_of_one) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(share_of_one, 0.0F, 1.0F) * 255.0F));
}

/// Distances in px from the hole's centre.
struct HoleShape {
  float radius_px;
  float rim_px;
};

HoleMask::Weights weights_at(float distance_px, const HoleShape& shape, float opacity) {
  const float half_rim = 0.5F * shape.rim_px;
  const float inside =
      1.0F - smooth_step(shape.radius_px - half_rim, shape.radius_px + half_rim, distance_px);
  const float wall = smooth_step(
      shape.radius_px - kWallWidth * shape.rim_px - half_rim, shape.radius_px, distance_px);
  const float dark = kDarkening + (kRimDarkening - kDarkening) * wall;
  const float from_ring = std::abs(distance_px - shape.radius_px - half_rim) / kRingHalfWidthPx;
  const float ring = std::max(0.0F, 1.0F - from_ring) * kRingStrength;
  return {
      to_byte(inside * opacity), to_byte(1.0F - inside * opacity * dark), to_byte(ring * opacity)};
}

/// One coordinate of a box: the whole pixels around [middle - reach, middle + reach], in [0, size).
std::pair<int, int> covered(float middle, float reach, int size) {
  const float limit = static_cast<float>(size);
  const int first = static_cast<int>(std::clamp(std::floor(middle - reach), 0.0F, limit));
  const int end = static_cast<int>(std::clamp(std::ceil(middle + reach) + 1.0F, 0.0F, limit));
  return {first, end - first};
}

bool same(const Hole& a, const Hole& b) {
  return a.center == b.center && a.radius == b.radius && a.rim == b.rim;
}

}  // namespace

void HoleMask::update(const Hole& hole, float opacity, int picture_width, int picture_height) {
  const bool is_current = same(hole, hole_) && opacity == opacity_ &&
                          picture_width == picture_width_ && picture_height == picture_height_;
  if (is_current) return;
  hole_ = hole;
  opacity_ = opacity;
  picture_width_ = picture_width;
  picture_height_ = picture_height;
  fill(hole, opacity, picture_width, picture_height);
}

bool HoleMask::reaches(int x, int y, float margin_px) const {
  if (!has_rim_) return true;
  const auto width = static_cast<float>(picture_width_);
  const auto height = static_cast<float>(picture_height_);
  const float dx = static_cast<float>(x) - (hole_.center.x() * width - 0.5F);
  const float dy = static_cast<float>(y) - (hole_.center.y() * height - 0.5F);
  const float reach = (hole_.radius + 0.5F * std::max(0.0F, hole_.rim)) * height + 1.5F * margin_px;
  return dx * dx + dy * dy <= reach * reach;
}

void HoleMask::fill(const Hole& hole, float opacity, int picture_width, int picture_height) {
  box_ = {};
  has_rim_ = hole.radius < kEverywhereRadius;
  if (hole.radius <= 0.0F || opacity <= 0.0F) return;
  if (!has_rim_) {
    box_ = {0, 0, picture_width, picture_height};
    const Weights everywhere = weights_at(0.0F, {1e6F, 0.0F}, opacity);
    weights_.assign(static_cast<std::size_t>(picture_width) * picture_height, everywhere);
    return;
  }
  const auto height = static_cast<float>(picture_height);
  const HoleShape shape{hole.radius * height, std::max(0.0F, hole.rim) * height};
  const float center_x = hole.center.x() * static_cast<float>(picture_width) - 0.5F;
  const float center_y = hole.center.y() * height - 0.5F;
  const float reach = shape.radius_px + 0.5F * shape.rim_px + kRingHalfWidthPx;
  std::tie(box_.left, box_.width) = covered(center_x, reach, picture_width);
  std::tie(box_.top, box_.height) = covered(center_y, reach, picture_height);
  weights_.clear();
  if (box_.empty()) return;
  weights_.reserve(static_cast<std::size_t>(box_.width) * box_.height);
  for (int y = box_.top; y < box_.top + box_.height; ++y) {
    for (int x = box_.left; x < box_.left + box_.width; ++x) {
      const float dx = static_cast<float>(x) - center_x;
      const float dy = static_cast<float>(y) - center_y;
      weights_.push_back(weights_at(std::sqrt(dx * dx + dy * dy), shape, opacity));
    }
  }
}

void copy_background(ImageView<const Rgb8> color, ImageView<Rgba8> picture) {
  // libyuv names bytes from the last one: its "RGB24" to "ARGB" keeps their order and appends
  // alpha.
  libyuv::RGB24ToARGB(&color.row(0)->r,
                      static_cast<int>(color.stride() * 3),
                      &picture.row(0)->r,
                      static_cast<int>(picture.stride() * 4),
                      color.width(),
                      color.height());
}

void smooth_outline(Layer& layer) {
  const auto width = static_cast<std::size_t>(layer.box.width);
  const auto height = static_cast<std::size_t>(layer.box.height);
  if (width < 3 || height < 3) return;
  Rgba8* const pixels = layer.pixels.data();
  // The rows as they were drawn, for the row below still needs them.
  std::vector<Rgba8> above(pixels, pixels + width);
  std::vector<Rgba8> here(width);
  for (std::size_t y = 1; y + 1 < height; ++y) {
    Rgba8* const row = pixels + y * width;
    const Rgba8* const below = row + width;
    std::copy(row, row + width, here.begin());
    for (std::size_t x = 1; x + 1 < width; ++x) {
      const bool a = here[x].a != 0;
      const bool is_outline = a != (here[x - 1].a != 0) || a != (here[x + 1].a != 0) ||
                              a != (above[x].a != 0) || a != (below[x].a != 0);
      if (!is_outline) continue;
      const auto mean = [&](std::uint8_t Rgba8::*channel) {
        const unsigned sides =
            here[x - 1].*channel + here[x + 1].*channel + above[x].*channel + below[x].*channel;
        return static_cast<std::uint8_t>((4U * (here[x].*channel) + sides + 4U) / 8U);
      };
      row[x] = {mean(&Rgba8::r), mean(&Rgba8::g), mean(&Rgba8::b), mean(&Rgba8::a)};
    }
    above.swap(here);
  }
}

void merge_layers(std::span<const Layer> layers, Layer& merged) {
  const PixelBox& box = merged.box;
  tbb::parallel_for(box.top, box.top + box.height, [&](int y) {
    Fragments fragments;
    for (int x = box.left; x < box.left + box.width; ++x) {
      fragments.gather(layers, x, y);
      if (fragments.size() == 0) continue;
      Rgba8 seen = fragments[0].color;
      for (int i = 1; i < fragments.size() && seen.a < 255; ++i) {
        const Rgba8& under = fragments[i].color;
        const unsigned left = 255U - seen.a;
        seen = {static_cast<std::uint8_t>(seen.r + share(under.r, left)),
                static_cast<std::uint8_t>(seen.g + share(under.g, left)),
                static_cast<std::uint8_t>(seen.b + share(under.b, left)),
                static_cast<std::uint8_t>(seen.a + share(under.a, left))};
      }
      const std::size_t at = merged.row_start(y) + static_cast<std::size_t>(x - box.left);
      merged.pixels[at] = seen;
      merged.depth_mm[at] = fragments[0].depth_mm;
    }
  });
}

void compose_hole(const HoleMask& mask,
                  const Layer& inside,
                  const PictureRays& rays,
                  const ViewGrid& grid,
                  const Occluders* occluders,
                  ImageView<Rgba8> picture) {
  const PixelBox& box = mask.box();
  tbb::parallel_for(box.top, box.top + box.height, [&](int y) {
    const HoleMask::Weights* weights = mask.row(y);
    const Rgba8* drawn = inside.row(y);
    const Eigen::Vector2f* ray = rays.row(y) + box.left;
    const std::uint8_t* in_front = occluders == nullptr ? nullptr : occluders->row(y, box.left);
    Rgba8* pixels = picture.row(y) + box.left;
    for (int x = 0; x < box.width; ++x) {
      const auto [structure, background, ring] = weights[x];
      if (structure == 0 && ring == 0) continue;
      const unsigned open = in_front == nullptr ? 255U : 255U - in_front[x];
      if (open == 0) continue;
      const unsigned body = to_byte(grid.body_share(ray[x]));
      const unsigned lit = 255U - share(share(255U - background, body), open);
      const unsigned over_share = share(structure, open);
      const unsigned behind = share(lit, 255U - share(drawn[x].a, over_share));
      const auto blend = [&, r = share(share(ring, body), open)](unsigned under, unsigned over) {
        const unsigned seen = std::min(255U, share(under, behind) + share(over, over_share));
        return static_cast<std::uint8_t>(seen + share(255U - seen, r));
      };
      pixels[x] = {blend(pixels[x].r, drawn[x].r),
                   blend(pixels[x].g, drawn[x].g),
                   blend(pixels[x].b, drawn[x].b),
                   255};
    }
  });
}

void compose_over(const Layer& layer, ImageView<Rgba8> picture) {
  const PixelBox& box = layer.box;
  for (int y = box.top; y < box.top + box.height; ++y) {
    const Rgba8* drawn = layer.row(y);
    Rgba8* pixels = picture.row(y) + box.left;
    for (int x = 0; x < box.width; ++x) {
      const unsigned behind = 255U - drawn[x].a;
      const auto blend = [behind](unsigned under, unsigned over) {
        return static_cast<std::uint8_t>(std::min(255U, share(under, behind) + over));
      };
      pixels[x] = {blend(pixels[x].r, drawn[x].r),
                   blend(pixels[x].g, drawn[x].g),
                   blend(pixels[x].b, drawn[x].b),
                   255};
    }
  }
}

}  // namespace mor::internal
