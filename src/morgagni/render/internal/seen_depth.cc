// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/seen_depth.h"

#include <algorithm>
#include <cmath>

#include "morgagni/geometry/depth_raster.h"

namespace mor::internal {
namespace {

constexpr int kMostPx = 800;  ///< In a row: as fine as any camera's pose is known.
/// Behind the outer side where the ray leaves through an end at which the CT cut the skin off.
constexpr float kOpenEndMm = 30.0F;

/// The pinhole that holds all rays of a camera, about as fine.
PinholeCamera pinhole_around(const PinholeCamera& camera) {
  Eigen::AlignedBox2d rays;
  const auto extend = [&](double x, double y) { rays.extend(camera.ray({x, y})); };
  for (int x = 0; x < camera.width_px; ++x) {
    extend(x, 0.0);
    extend(x, camera.height_px - 1.0);
  }
  for (int y = 0; y < camera.height_px; ++y) {
    extend(0.0, y);
    extend(camera.width_px - 1.0, y);
  }
  const double scale = std::min(1.0, static_cast<double>(kMostPx) / camera.width_px);
  PinholeCamera pinhole;
  pinhole.focal_x_px = camera.focal_x_px * scale;
  pinhole.focal_y_px = camera.focal_y_px * scale;
  // A pixel more on each side, for what is looked up between two of them.
  pinhole.center_x_px = 1.0 - rays.min().x() * pinhole.focal_x_px;
  pinhole.center_y_px = 1.0 - rays.min().y() * pinhole.focal_y_px;
  const auto size = [](double range) {
    return std::clamp(static_cast<int>(std::ceil(range)) + 3, 4, 2 * kMostPx);
  };
  pinhole.width_px = size(rays.sizes().x() * pinhole.focal_x_px);
  pinhole.height_px = size(rays.sizes().y() * pinhole.focal_y_px);
  return pinhole;
}

float limit(float outer, float inner) {
  if (outer <= 0.0F) return inner <= 0.0F ? SeenDepth::kNothingThere : inner;
  if (inner <= 0.0F) return outer + kOpenEndMm;
  return inner < outer ? inner : 0.5F * (outer + inner);
}

}  // namespace

void SeenDepth::update(const TriangleMesh& skin,
                       const PinholeCamera& camera,
                       const Eigen::Isometry3d& camera_from_ct) {
  if (!(camera == source_)) {
    source_ = camera;
    camera_ = pinhole_around(camera);
  }
  TwoSidedDepth sides = rasterize_sides(skin, camera_, camera_from_ct);
  limit_mm_ = std::move(sides.outer_mm);
  std::transform(limit_mm_.data(),
                 limit_mm_.data() + limit_mm_.size(),
                 sides.inner_mm.data(),
                 limit_mm_.data(),
                 limit);
}

}  // namespace mor::internal
