// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/depth_raster.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mor {
namespace {

constexpr float kNearestMm = 1.0F;

/// A vertex on the picture: pixel position and 1/z, which is linear across a triangle there.
struct Projected {
  float x_px = 0.0F;
  float y_px = 0.0F;
  float inverse_depth = 0.0F;  ///< 0: behind the nearest plane.
};

std::vector<Projected> project_all(const TriangleMesh& mesh,
                                   const PinholeCamera& camera,
                                   const Eigen::Isometry3d& camera_from_mesh) {
  const Eigen::Isometry3f to_camera = camera_from_mesh.cast<float>();
  const auto fx = static_cast<float>(camera.focal_x_px);
  const auto fy = static_cast<float>(camera.focal_y_px);
  const auto cx = static_cast<float>(camera.center_x_px);
  const auto cy = static_cast<float>(camera.center_y_px);
  std::vector<Projected> projected(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f p = to_camera * mesh.vertices[i];
    if (p.z() < kNearestMm) continue;
    const float inverse = 1.0F / p.z();
    projected[i] = {fx * p.x() * inverse + cx, fy * p.y() * inverse + cy, inverse};
  }
  return projected;
}

float cross(const Projected& a, const Projected& b, float x, float y) {
  return (b.x_px - a.x_px) * (y - a.y_px) - (b.y_px - a.y_px) * (x - a.x_px);
}

/// The pixels whose centres lie in [low, high], within [0, size).
struct PixelSpan {
  PixelSpan(float low, float high, int size)
      : first(static_cast<int>(std::ceil(std::max(low, 0.0F)))),
        last(static_cast<int>(std::floor(std::min(high, static_cast<float>(size - 1))))) {}
  int first;
  int last;
};

void draw(const Projected& a,
          const Projected& b,
          const Projected& c,
          std::uint32_t index,
          Image<float>& nearest_inverse,
          Image<std::uint32_t>& triangle_idx) {
  const float area = cross(a, b, c.x_px, c.y_px);
  if (area == 0.0F || !std::isfinite(area)) return;
  const float inverse_area = 1.0F / area;
  const PixelSpan rows(std::min({a.y_px, b.y_px, c.y_px}),
                       std::max({a.y_px, b.y_px, c.y_px}),
                       nearest_inverse.height());
  const PixelSpan columns(std::min({a.x_px, b.x_px, c.x_px}),
                          std::max({a.x_px, b.x_px, c.x_px}),
                          nearest_inverse.width());
  for (int y = rows.first; y <= rows.last; ++y) {
    for (int x = columns.first; x <= columns.last; ++x) {
      const auto px = static_cast<float>(x);
      const auto py = static_cast<float>(y);
      const float weight_a = cross(b, c, px, py) * inverse_area;
      const float weight_b = cross(c, a, px, py) * inverse_area;
      const float weight_c = 1.0F - weight_a - weight_b;
      if (weight_a < 0.0F || weight_b < 0.0F || weight_c < 0.0F) continue;
      const float inverse =
          weight_a * a.inverse_depth + weight_b * b.inverse_depth + weight_c * c.inverse_depth;
      if (inverse <= nearest_inverse(x, y)) continue;
      nearest_inverse(x, y) = inverse;
      triangle_idx(x, y) = index;
    }
  }
}

}  // namespace

DepthRaster rasterize_depth(const TriangleMesh& mesh,
                            const PinholeCamera& camera,
                            const Eigen::Isometry3d& camera_from_mesh) {
  DepthRaster raster{
      Image<float>(camera.width_px, camera.height_px, 0.0F),
      Image<std::uint32_t>(camera.width_px, camera.height_px, DepthRaster::kNothing)};
  const auto projected = project_all(mesh, camera, camera_from_mesh);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const bool in_front = projected[a].inverse_depth > 0.0F && projected[b].inverse_depth > 0.0F &&
                          projected[c].inverse_depth > 0.0F;
    if (!in_front) continue;
    draw(projected[a],
         projected[b],
         projected[c],
         static_cast<std::uint32_t>(i),
         raster.depth_mm,
         raster.triangle_idx);
  }
  for (std::size_t i = 0; i < raster.depth_mm.size(); ++i) {
    float& value = raster.depth_mm.data()[i];
    if (value > 0.0F) value = 1.0F / value;
  }
  return raster;
}

}  // namespace mor
