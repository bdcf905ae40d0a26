// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/depth/body_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/depth/internal/depth_grid.h"
#include "morgagni/depth/internal/grid_normals.h"
#include "morgagni/depth/internal/reading_average.h"
#include "morgagni/geometry/depth_levels.h"

namespace mor {
namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// The pixels that are looked at along one side: 0, round(factor), round(2 factor), ...
std::vector<int> sampled_pixels(int size_px, double factor) {
  std::vector<int> pixels;
  for (int i = 0;; ++i) {
    const int pixel = static_cast<int>(std::lround(i * factor));
    if (pixel >= size_px) return pixels;
    pixels.push_back(pixel);
  }
}

/// The four corners of a grid cell: above left, above right, below left, below right.
struct Cell {
  std::uint32_t a, b, c, d;
};

/// One or two triangles of a cell, along its shorter diagonal.
void add_cell_triangles(const Cell& cell,
                        std::uint8_t bits,
                        bool b_to_d,
                        bool c_to_d,
                        bool ad_is_shorter,
                        std::vector<Triangle>& triangles) {
  const bool a_to_b = (bits & internal::kRight) != 0;
  const bool a_to_c = (bits & internal::kDown) != 0;
  const bool a_to_d = (bits & internal::kDownRight) != 0;
  const bool c_to_b = (bits & internal::kDownLeft) != 0;  // Of b, handed over by the caller.
  const bool by_ad = a_to_d && (ad_is_shorter || !c_to_b);
  if (by_ad) {
    if (a_to_c && c_to_d) triangles.push_back({cell.a, cell.c, cell.d});
    if (a_to_b && b_to_d) triangles.push_back({cell.a, cell.d, cell.b});
  } else if (c_to_b) {
    if (a_to_b && a_to_c) triangles.push_back({cell.a, cell.c, cell.b});
    if (b_to_d && c_to_d) triangles.push_back({cell.b, cell.c, cell.d});
  }
}

bool in_picture(const Eigen::Vector2d& pixel, const PinholeCamera& camera) {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= camera.width_px - 1.0 &&
         pixel.y() <= camera.height_px - 1.0;
}

}  // namespace

Result<void> BodySurfaceOptions::check() const {
  const auto bad = [](const char* what, double value) {
    return make_error(ErrorCode::kInvalidArgument, fmt::format("{}, got {}", what, value));
  };
  if (!(near_mm >= 0.0) || !std::isfinite(near_mm)) return bad("near_mm must be >= 0", near_mm);
  if (!(far_mm > near_mm) || !std::isfinite(far_mm)) {
    return bad("far_mm must be greater than near_mm", far_mm);
  }
  if (!(max_edge_mm > 0.0) || !std::isfinite(max_edge_mm)) {
    return bad("max_edge_mm must be greater than 0", max_edge_mm);
  }
  if (!(down_sampling >= 1.0 && down_sampling <= 4.0)) {
    return bad("down_sampling must be in [1, 4]", down_sampling);
  }
  return {};
}

struct BodySurfaceExtractor::Impl {
  Impl(const PinholeCamera& depth_camera, const BodySurfaceOptions& surface_options);

  [[nodiscard]] int grid_position(std::optional<double> pixel, int size) const;
  [[nodiscard]] Result<void> take(ImageView<const std::uint16_t> depth_mm);
  void back_project(ImageView<const std::uint16_t> depth_mm);
  [[nodiscard]] std::size_t grow_from(std::optional<Eigen::Vector2d> seed_px);
  [[nodiscard]] std::size_t grow_around(std::span<const Eigen::Vector3d> expected);
  void average(ImageView<const std::uint16_t> depth_mm);
  [[nodiscard]] BodySurface surface(ImageView<const std::uint16_t> depth_mm, std::size_t count);
  void add_vertices(std::size_t count, PointCloud& cloud);
  void add_triangles(std::size_t num_vertices, std::vector<Triangle>& triangles) const;
  [[nodiscard]] bool ad_is_shorter(std::size_t a) const;

  PinholeCamera camera;
  BodySurfaceOptions options;
  std::vector<int> columns, rows;
  std::vector<float> ray_x, ray_y;
  DepthLevels levels;
  internal::DepthGrid grid;
  internal::RegionGrower grower;
  internal::GridNormals normals;
  internal::ReadingAverage averages;
  std::vector<std::uint8_t> edges, edges_before, mask;
  std::vector<std::uint32_t> vertex_of_pixel;
};

BodySurfaceExtractor::Impl::Impl(const PinholeCamera& depth_camera,
                                 const BodySurfaceOptions& surface_options)
    : camera(depth_camera),
      options(surface_options),
      columns(sampled_pixels(camera.width_px, options.down_sampling)),
      rows(sampled_pixels(camera.height_px, options.down_sampling)),
      normals(camera,
              options.down_sampling,
              static_cast<int>(columns.size()),
              static_cast<int>(rows.size())),
      averages(camera,
               options.down_sampling,
               static_cast<int>(columns.size()),
               static_cast<int>(rows.size())) {
  grid.width = static_cast<int>(columns.size());
  grid.height = static_cast<int>(rows.size());
  const std::size_t count = columns.size() * rows.size();
  for (auto* values : {&ray_x, &ray_y}) values->reserve(count);
  for (auto* values : {&grid.x, &grid.y, &grid.z}) values->resize(count);
  for (const int row : rows) {
    for (const int column : columns) {
      const Eigen::Vector2d ray = camera.ray(Eigen::Vector2d(column, row));
      ray_x.push_back(static_cast<float>(ray.x()));
      ray_y.push_back(static_cast<float>(ray.y()));
    }
  }
}

/// The grid's column or row nearest to a pixel coordinate; the middle one for none.
int BodySurfaceExtractor::Impl::grid_position(std::optional<double> pixel, int size) const {
  if (!pixel || !std::isfinite(*pixel)) return size / 2;
  const double position = std::clamp(*pixel / options.down_sampling, 0.0, size - 1.0);
  return static_cast<int>(std::lround(position));
}

void BodySurfaceExtractor::Impl::back_project(ImageView<const std::uint16_t> depth_mm) {
  const auto near_mm = static_cast<float>(options.near_mm);
  const auto far_mm = static_cast<float>(options.far_mm);
  std::size_t i = 0;
  for (const int row : rows) {
    const std::uint16_t* depth_row = depth_mm.row(row);
    for (const int column : columns) {
      const float z = levels.mm(depth_row[column]);
      const bool seen = z > 0.0F && z >= near_mm && z <= far_mm;
      grid.z[i++] = seen ? z : std::numeric_limits<float>::quiet_NaN();
    }
  }
  for (i = 0; i < grid.size(); ++i) {
    grid.x[i] = ray_x[i] * grid.z[i];
    grid.y[i] = ray_y[i] * grid.z[i];
  }
}

/// Back-projects a picture and connects its pixels.
Result<void> BodySurfaceExtractor::Impl::take(ImageView<const std::uint16_t> depth_mm) {
  if (depth_mm.width() != camera.width_px || depth_mm.height() != camera.height_px) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("the depth image is {}x{} but the camera's pictures are {}x{}",
                                  depth_mm.width(),
                                  depth_mm.height(),
                                  camera.width_px,
                                  camera.height_px));
  }
  levels.learn(depth_mm);
  back_project(depth_mm);
  internal::connect_neighbors(grid, static_cast<float>(options.max_edge_mm), edges);
  return {};
}

std::size_t BodySurfaceExtractor::Impl::grow_from(std::optional<Eigen::Vector2d> seed_px) {
  return grower.grow(
      grid,
      edges,
      grid_position(seed_px ? std::optional(seed_px->x()) : std::nullopt, grid.width),
      grid_position(seed_px ? std::optional(seed_px->y()) : std::nullopt, grid.height),
      mask);
}

std::size_t BodySurfaceExtractor::Impl::grow_around(std::span<const Eigen::Vector3d> expected) {
  std::vector<internal::RegionGrower::Expected> places;
  places.reserve(expected.size());
  for (const Eigen::Vector3d& place : expected) {
    const auto pixel = camera.project(place);
    if (!pixel || !in_picture(*pixel, camera)) continue;
    places.push_back({grid_position(pixel->x(), grid.width),
                      grid_position(pixel->y(), grid.height),
                      static_cast<float>(place.z())});
  }
  return grower.grow(grid, edges, places, mask);
}

/// Puts the pixels in the mask where the mean of the readings around them lies, and cuts the edges
/// that this makes too long.
void BodySurfaceExtractor::Impl::average(ImageView<const std::uint16_t> depth_mm) {
  averages.put_at_means(depth_mm, levels, mask, grid);
  averages.undo_flattening(edges, mask, grid);
  edges_before = edges;
  internal::connect_neighbors(grid, static_cast<float>(options.max_edge_mm), edges);
  for (std::size_t k = 0; k < edges.size(); ++k) edges[k] &= edges_before[k];
}

/// The surface of the `count` pixels in the mask.
BodySurface BodySurfaceExtractor::Impl::surface(ImageView<const std::uint16_t> depth_mm,
                                                std::size_t count) {
  BodySurface surface;
  if (count == 0) return surface;
  if (options.averages && options.down_sampling > 1.0) average(depth_mm);
  normals.fit(grid.z, mask);
  add_vertices(count, surface.cloud);
  add_triangles(count, surface.triangles);
  return surface;
}

void BodySurfaceExtractor::Impl::add_vertices(std::size_t count, PointCloud& cloud) {
  cloud.points.reserve(count);
  cloud.normals.reserve(count);
  vertex_of_pixel.assign(grid.size(), kNoVertex);
  std::size_t i = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x, ++i) {
      if (mask[i] == 0) continue;
      vertex_of_pixel[i] = static_cast<std::uint32_t>(cloud.points.size());
      cloud.points.emplace_back(grid.x[i], grid.y[i], grid.z[i]);
      cloud.normals.push_back(normals.at(x, y));
    }
  }
}

/// Compares the diagonals of the cell whose upper left corner is `a`, where both exist. They are as
/// long across the picture, so their depths tell.
bool BodySurfaceExtractor::Impl::ad_is_shorter(std::size_t a) const {
  const auto width = static_cast<std::size_t>(grid.width);
  return std::abs(grid.z[a] - grid.z[a + width + 1]) <= std::abs(grid.z[a + 1] - grid.z[a + width]);
}

void BodySurfaceExtractor::Impl::add_triangles(std::size_t num_vertices,
                                               std::vector<Triangle>& triangles) const {
  triangles.reserve(2 * num_vertices);
  const auto width = static_cast<std::size_t>(grid.width);
  for (int y = 0; y + 1 < grid.height; ++y) {
    for (int x = 0; x + 1 < grid.width; ++x) {
      const std::size_t a = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
      const std::size_t b = a + 1;
      const std::size_t c = a + width;
      // Edges join pixels of one part, so either end tells whether an edge is the body's.
      if (mask[a] == 0 && mask[b] == 0) continue;
      const int of_a = mask[a] != 0 ? edges[a] & ~internal::kDownLeft : 0;
      const int of_b = mask[b] != 0 ? edges[b] & internal::kDownLeft : 0;
      const Cell cell{
          vertex_of_pixel[a], vertex_of_pixel[b], vertex_of_pixel[c], vertex_of_pixel[c + 1]};
      add_cell_triangles(cell,
                         static_cast<std::uint8_t>(of_a | of_b),
                         (edges[b] & internal::kDown) != 0,
                         (edges[c] & internal::kRight) != 0,
                         ad_is_shorter(a),
                         triangles);
    }
  }
}

Result<BodySurfaceExtractor> BodySurfaceExtractor::create(const PinholeCamera& depth_camera,
                                                          const BodySurfaceOptions& options) {
  MOR_CHECK(depth_camera.check());
  MOR_CHECK(options.check());
  return BodySurfaceExtractor(std::make_unique<Impl>(depth_camera, options));
}

BodySurfaceExtractor::BodySurfaceExtractor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BodySurfaceExtractor::BodySurfaceExtractor(BodySurfaceExtractor&&) noexcept = default;
BodySurfaceExtractor& BodySurfaceExtractor::operator=(BodySurfaceExtractor&&) noexcept = default;
BodySurfaceExtractor::~BodySurfaceExtractor() = default;

Result<BodySurface> BodySurfaceExtractor::extract(ImageView<const std::uint16_t> depth_mm,
                                                  std::optional<Eigen::Vector2d> seed_px) {
  MOR_CHECK(impl_->take(depth_mm));
  return impl_->surface(depth_mm, impl_->grow_from(seed_px));
}

Result<BodySurface> BodySurfaceExtractor::extract(ImageView<const std::uint16_t> depth_mm,
                                                  std::span<const Eigen::Vector3d> expected) {
  MOR_CHECK(impl_->take(depth_mm));
  const std::size_t count = impl_->grow_around(expected);
  return impl_->surface(depth_mm, count > 0 ? count : impl_->grow_from(std::nullopt));
}

}  // namespace mor
