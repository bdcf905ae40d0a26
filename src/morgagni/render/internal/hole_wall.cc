// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/hole_wall.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace mor::internal {
namespace {

constexpr int kNumSectors = 128;
constexpr float kWallMm = 50.0F;     ///< Depth at which the wall ends.
constexpr float kFadeFrom = 0.45F;   ///< Share of its depth from which it fades.
constexpr float kRimLight = 0.80F;   ///< Of the rim's colour, at the rim
constexpr float kDeepLight = 0.16F;  ///< and at the wall's end.
constexpr float kSideLight =
    0.30F;  ///< More on the side that faces the upper left, less on the other.
constexpr float kColorFromPx = 3.0F;  ///< Outside of the rim, where its colour is taken.
constexpr float kPi = std::numbers::pi_v<float>;

/// What the wall is like in one direction from the hole's centre.
struct Sector {
  float skin_mm = 0.0F;  ///< 0: no skin on the rim there, so no wall.
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float body_share = 0.0F;
};

using Sectors = std::array<Sector, kNumSectors>;

struct Circle {
  Eigen::Vector2f center_px;
  float radius_px;
};

float smooth_step(float low, float high, float value) {
  const float t = std::clamp((value - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

Sector sector_at(float angle,
                 const Circle& circle,
                 ImageView<const Rgba8> picture,
                 const PictureRays& rays,
                 const ViewGrid& grid) {
  const Eigen::Vector2f direction(std::cos(angle), std::sin(angle));
  const auto pixel_at = [&](float radius_px) {
    const Eigen::Vector2f at = circle.center_px + radius_px * direction;
    return Eigen::Vector2i(std::clamp(static_cast<int>(at.x() + 0.5F), 0, picture.width() - 1),
                           std::clamp(static_cast<int>(at.y() + 0.5F), 0, picture.height() - 1));
  };
  const Eigen::Vector2i rim = pixel_at(circle.radius_px);
  const Eigen::Vector2f& ray = rays.row(rim.y())[rim.x()];
  const Eigen::Vector2i beside = pixel_at(circle.radius_px + kColorFromPx);
  const Rgba8& color = picture(beside.x(), beside.y());
  return {grid.skin_at(ray), Eigen::Vector3f(color.r, color.g, color.b), grid.body_share(ray)};
}

/// Each sector's mean over those beside it: skin and colour change slowly along the rim.
Sectors smoothed(const Sectors& sectors) {
  constexpr int kReach = 4;
  Sectors result;
  for (int i = 0; i < kNumSectors; ++i) {
    Sector mean;
    float num_skin = 0.0F;
    for (int j = i - kReach; j <= i + kReach; ++j) {
      const Sector& sector = sectors[static_cast<std::size_t>((j + kNumSectors) % kNumSectors)];
      mean.color += sector.color;
      mean.body_share += sector.body_share;
      mean.skin_mm += sector.skin_mm;
      num_skin += sector.skin_mm > 0.0F ? 1.0F : 0.0F;
    }
    mean.color /= 2 * kReach + 1;
    mean.body_share /= 2 * kReach + 1;
    if (num_skin > 0.0F) mean.skin_mm /= num_skin;
    result[static_cast<std::size_t>(i)] = mean;
  }
  return result;
}

Rgba8 premultiplied(const Eigen::Vector3f& color, float alpha) {
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
  };
  return {byte(color.x() * alpha),
          byte(color.y() * alpha),
          byte(color.z() * alpha),
          byte(255.0F * alpha)};
}

}  // namespace

void draw_hole_wall(const Hole& hole,
                    ImageView<const Rgba8> picture,
                    const PictureRays& rays,
                    const ViewGrid& grid,
                    Layer& wall) {
  const auto height = static_cast<float>(picture.height());
  const Circle circle{{hole.center.x() * static_cast<float>(picture.width()) - 0.5F,
                       hole.center.y() * height - 0.5F},
                      (hole.radius + 0.5F * std::max(hole.rim, 0.0F)) * height};
  Sectors raw;
  for (int i = 0; i < kNumSectors; ++i) {
    const float angle = 2.0F * kPi * static_cast<float>(i) / kNumSectors - kPi;
    raw[static_cast<std::size_t>(i)] = sector_at(angle, circle, picture, rays, grid);
  }
  const Sectors sectors = smoothed(raw);
  float nearest_mm = kNoDepth;
  for (const Sector& sector : sectors) {
    if (sector.skin_mm > 0.0F) nearest_mm = std::min(nearest_mm, sector.skin_mm);
  }
  if (nearest_mm == kNoDepth) return;
  const float end_px = circle.radius_px * nearest_mm / (nearest_mm + kWallMm);
  for (int y = wall.box.top; y < wall.box.top + wall.box.height; ++y) {
    for (int x = wall.box.left; x < wall.box.left + wall.box.width; ++x) {
      const Eigen::Vector2f from_center =
          Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - circle.center_px;
      const float distance_px = from_center.norm();
      if (distance_px <= end_px || distance_px > circle.radius_px) continue;
      const float turn = std::atan2(from_center.y(), from_center.x()) / (2.0F * kPi) + 0.5F;
      const int index = static_cast<int>(turn * kNumSectors + 0.5F) % kNumSectors;
      const Sector& sector = sectors[static_cast<std::size_t>(index)];
      if (sector.skin_mm <= 0.0F) continue;
      const float depth_mm = sector.skin_mm * circle.radius_px / distance_px;
      const float down = (depth_mm - sector.skin_mm) / kWallMm;
      if (down >= 1.0F) continue;
      const Eigen::Vector2f direction = from_center / distance_px;
      const float facing = (direction.x() + direction.y()) * std::numbers::sqrt2_v<float> * 0.5F;
      const float light =
          (kRimLight + (kDeepLight - kRimLight) * std::sqrt(down)) * (1.0F + kSideLight * facing);
      const float alpha = sector.body_share * (1.0F - smooth_step(kFadeFrom, 1.0F, down));
      const std::size_t i = wall.row_start(y) + static_cast<std::size_t>(x - wall.box.left);
      wall.pixels[i] = premultiplied(sector.color * light, alpha);
      wall.depth_mm[i] = depth_mm;
    }
  }
}

}  // namespace mor::internal
