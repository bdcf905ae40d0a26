// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/depth_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace mor {
namespace {

constexpr float kNearestMm = 1.0F;

/// Four pixels of a row, in GCC's and Clang's portable vectors: what most triangles span.
constexpr int kNumLanes = 4;
using Floats = float __attribute__((vector_size(4 * kNumLanes)));
using Indices = std::uint32_t __attribute__((vector_size(4 * kNumLanes)));
constexpr Floats kLane = {0, 1, 2, 3};

template <class Lanes, class T>
Lanes load(const T* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

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

/// The pixels whose centres lie in [low, high], within [0, size).
struct PixelSpan {
  PixelSpan(float low, float high, int size)
      : first(static_cast<int>(std::ceil(std::max(low, 0.0F)))),
        last(static_cast<int>(std::floor(std::min(high, static_cast<float>(size - 1))))) {}
  int first;
  int last;
};

/// A value that is linear over the picture.
struct Plane {
  float at_origin = 0.0F;
  float per_x = 0.0F;
  float per_y = 0.0F;

  [[nodiscard]] Floats at(Floats x, float y) const { return at_origin + y * per_y + x * per_x; }
};

/// Twice the area of a triangle on the picture, whose rows run downwards: negative where its outer
/// side is seen.
float twice_area(const Projected& a, const Projected& b, const Projected& c) {
  return (b.x_px - a.x_px) * (c.y_px - a.y_px) - (b.y_px - a.y_px) * (c.x_px - a.x_px);
}

/// Twice the area of (a, b, pixel), positive inside a counter-clockwise triangle; widened by its
/// rounding error, so that two triangles leave no gap along the edge they share.
Plane edge(const Projected& a, const Projected& b, float origin_x, float origin_y, float reach_px) {
  constexpr float kRounding = 2.4e-7F;  // Four halves of a float's last place.
  const float dx = b.x_px - a.x_px;
  const float dy = b.y_px - a.y_px;
  const float slack = kRounding * reach_px * (std::abs(dx) + std::abs(dy));
  return {dx * (origin_y - a.y_px) - dy * (origin_x - a.x_px) + slack, -dy, dx};
}

/// The inverse depth, which is linear over the picture, from the corners' values.
Plane inverse_depth_plane(const Projected& a,
                          const Projected& b,
                          const Projected& c,
                          float area,
                          float origin_x,
                          float origin_y) {
  const float to_b = b.inverse_depth - a.inverse_depth;
  const float to_c = c.inverse_depth - a.inverse_depth;
  const float per_x = (to_b * (c.y_px - a.y_px) - to_c * (b.y_px - a.y_px)) / area;
  const float per_y = (to_c * (b.x_px - a.x_px) - to_b * (c.x_px - a.x_px)) / area;
  return {
      a.inverse_depth + per_x * (origin_x - a.x_px) + per_y * (origin_y - a.y_px), per_x, per_y};
}

class Canvas {
 public:
  explicit Canvas(DepthRaster& raster)
      : nearest_inverse_(raster.depth_mm.view()), triangle_idx_(raster.triangle_idx.view()) {}

  void draw(const Projected& a, Projected b, Projected c, std::uint32_t index) {
    const float left = std::min({a.x_px, b.x_px, c.x_px});
    const float right = std::max({a.x_px, b.x_px, c.x_px});
    const float top = std::min({a.y_px, b.y_px, c.y_px});
    const float bottom = std::max({a.y_px, b.y_px, c.y_px});
    const PixelSpan rows(top, bottom, nearest_inverse_.height());
    const PixelSpan columns(left, right, nearest_inverse_.width());
    if (rows.first > rows.last || columns.first > columns.last) return;
    float area = twice_area(a, b, c);
    if (area < 0.0F) {
      std::swap(b, c);
      area = -area;
    }
    if (!(area > 0.0F) || !std::isfinite(area)) return;
    const auto x = static_cast<float>(columns.first);
    const auto y = static_cast<float>(rows.first);
    const float reach_px = right - left + bottom - top;
    const Filling filling{
        .edges = {edge(a, b, x, y, reach_px),
                  edge(b, c, x, y, reach_px),
                  edge(c, a, x, y, reach_px)},
        .inverse_depth = inverse_depth_plane(a, b, c, area, x, y),
        // A sliver's gradient is mostly rounding: it must not reach beyond its corners.
        .least = std::min({a.inverse_depth, b.inverse_depth, c.inverse_depth}),
        .most = std::max({a.inverse_depth, b.inverse_depth, c.inverse_depth}),
        .index = index};
    fill(filling, rows, columns);
  }

 private:
  struct Filling {
    std::array<Plane, 3> edges;
    Plane inverse_depth;
    float least;
    float most;
    std::uint32_t index;
  };

  /// Four pixels at a time, without a branch. A block may begin left of the triangle or end right
  /// of it: its edges keep the rest out.
  void fill(const Filling& filling, PixelSpan rows, PixelSpan columns) {
    const auto& [e0, e1, e2] = filling.edges;
    for (int y = rows.first; y <= rows.last; ++y) {
      const auto down = static_cast<float>(y - rows.first);
      for (int block = columns.first; block <= columns.last; block += kNumLanes) {
        const int x = std::min(block, nearest_inverse_.width() - kNumLanes);
        const Floats right = kLane + static_cast<float>(x - columns.first);
        const Floats plane = filling.inverse_depth.at(right, down);
        const Floats above = plane < filling.least ? Floats{} + filling.least : plane;
        const Floats inverse = above > filling.most ? Floats{} + filling.most : above;
        Floats nearest = load<Floats>(nearest_inverse_.row(y) + x);
        Indices seen = load<Indices>(triangle_idx_.row(y) + x);
        const auto is_seen = (e0.at(right, down) >= 0.0F) & (e1.at(right, down) >= 0.0F) &
                             (e2.at(right, down) >= 0.0F) & (inverse > nearest);
        nearest = is_seen ? inverse : nearest;
        seen = is_seen ? Indices{} + filling.index : seen;
        std::memcpy(nearest_inverse_.row(y) + x, &nearest, sizeof nearest);
        std::memcpy(triangle_idx_.row(y) + x, &seen, sizeof seen);
      }
    }
  }

  ImageView<float> nearest_inverse_;
  ImageView<std::uint32_t> triangle_idx_;
};

template <class T>
Image<T> left_part(const Image<T>& image, int width) {
  Image<T> part(width, image.height());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < width; ++x) part(x, y) = image(x, y);
  }
  return part;
}

DepthRaster empty_raster(const PinholeCamera& camera) {
  return {Image<float>(camera.width_px, camera.height_px, 0.0F),
          Image<std::uint32_t>(camera.width_px, camera.height_px, DepthRaster::kNothing)};
}

/// Calls `draw(a, b, c, index)` for each triangle that is wholly in front of the camera.
template <class Draw>
void for_each_projected(const TriangleMesh& mesh,
                        const PinholeCamera& camera,
                        const Eigen::Isometry3d& camera_from_mesh,
                        const Draw& draw) {
  const auto projected = project_all(mesh, camera, camera_from_mesh);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const bool in_front = projected[a].inverse_depth > 0.0F && projected[b].inverse_depth > 0.0F &&
                          projected[c].inverse_depth > 0.0F;
    if (in_front) draw(projected[a], projected[b], projected[c], static_cast<std::uint32_t>(i));
  }
}

void invert(Image<float>& inverse_depth) {
  for (std::size_t i = 0; i < inverse_depth.size(); ++i) {
    float& value = inverse_depth.data()[i];
    if (value > 0.0F) value = 1.0F / value;
  }
}

/// The camera, wide enough for the lanes.
PinholeCamera wide_enough(const PinholeCamera& camera) {
  PinholeCamera wider = camera;
  wider.width_px = std::max(camera.width_px, kNumLanes);
  return wider;
}

}  // namespace

DepthRaster rasterize_depth(const TriangleMesh& mesh,
                            const PinholeCamera& camera,
                            const Eigen::Isometry3d& camera_from_mesh) {
  const PinholeCamera wide = wide_enough(camera);
  DepthRaster raster = empty_raster(wide);
  Canvas canvas(raster);
  for_each_projected(
      mesh, wide, camera_from_mesh, [&](const auto& a, const auto& b, const auto& c, auto i) {
        canvas.draw(a, b, c, i);
      });
  invert(raster.depth_mm);
  if (wide == camera) return raster;
  return {left_part(raster.depth_mm, camera.width_px),
          left_part(raster.triangle_idx, camera.width_px)};
}

TwoSidedDepth rasterize_sides(const TriangleMesh& mesh,
                              const PinholeCamera& camera,
                              const Eigen::Isometry3d& camera_from_mesh) {
  const PinholeCamera wide = wide_enough(camera);
  DepthRaster outer = empty_raster(wide);
  DepthRaster inner = empty_raster(wide);
  Canvas outer_canvas(outer);
  Canvas inner_canvas(inner);
  for_each_projected(
      mesh, wide, camera_from_mesh, [&](const auto& a, const auto& b, const auto& c, auto i) {
        (twice_area(a, b, c) < 0.0F ? outer_canvas : inner_canvas).draw(a, b, c, i);
      });
  invert(outer.depth_mm);
  invert(inner.depth_mm);
  if (wide == camera) return {std::move(outer.depth_mm), std::move(inner.depth_mm)};
  return {left_part(outer.depth_mm, camera.width_px), left_part(inner.depth_mm, camera.width_px)};
}

}  // namespace mor
