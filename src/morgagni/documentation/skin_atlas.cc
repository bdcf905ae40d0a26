// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/skin_atlas.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/documentation/internal/skin_charts.h"
#include "morgagni/documentation/skin_texture_io.h"

namespace mor {
namespace {

using Eigen::Vector2f;
using internal::FlatTriangle;
using internal::SkinChart;

/// A chart in texels, its corner at (0, 0), and the outline that packing goes by: of each column
/// the first and the last row that it takes, half the gutter included.
struct FlatChart {
  std::vector<FlatTriangle> triangles;
  std::vector<int> top;
  std::vector<int> bottom;
  int height_px = 0;
};

double flat_area(const std::vector<FlatTriangle>& flat) {
  double area = 0.0;
  for (const auto& [a, b, c] : flat) {
    const Vector2f u = b - a;
    const Vector2f v = c - a;
    area += 0.5 * std::abs(u.x() * v.y() - u.y() * v.x());
  }
  return area;
}

double skin_area(const TriangleMesh& mesh, const SkinChart& chart) {
  double area = 0.0;
  for (const auto triangle : chart.triangles) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    area += 0.5 *
            (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
  }
  return area;
}

void trace_outline(FlatChart& chart, int rim_px) {
  int width = 0;
  for (const auto& triangle : chart.triangles) {
    for (const auto& p : triangle) width = std::max(width, static_cast<int>(std::ceil(p.x())));
  }
  width += rim_px + 1;
  chart.top.assign(static_cast<std::size_t>(width), std::numeric_limits<int>::max());
  chart.bottom.assign(static_cast<std::size_t>(width), -1);
  for (const auto& triangle : chart.triangles) {
    const auto [left, right] = std::minmax({triangle[0].x(), triangle[1].x(), triangle[2].x()});
    const auto [above, below] = std::minmax({triangle[0].y(), triangle[1].y(), triangle[2].y()});
    const int first = std::max(0, static_cast<int>(std::floor(left)) - rim_px);
    const int last = std::min(width - 1, static_cast<int>(std::ceil(right)) + rim_px);
    const int top = std::max(0, static_cast<int>(std::floor(above)) - rim_px);
    const int bottom = static_cast<int>(std::ceil(below)) + rim_px;
    for (int x = first; x <= last; ++x) {
      auto& highest = chart.top[static_cast<std::size_t>(x)];
      auto& lowest = chart.bottom[static_cast<std::size_t>(x)];
      highest = std::min(highest, top);
      lowest = std::max(lowest, bottom);
    }
    chart.height_px = std::max(chart.height_px, bottom + 1);
  }
}

FlatChart flat_chart(const TriangleMesh& mesh, const SkinChart& chart, double px_per_mm, int rim) {
  FlatChart result;
  result.triangles = internal::laid_flat(mesh, chart);
  const double flat_mm2 = flat_area(result.triangles);
  const double stretch = flat_mm2 > 0.0 ? std::sqrt(skin_area(mesh, chart) / flat_mm2) : 1.0;
  const auto scale = static_cast<float>(px_per_mm * stretch);
  Vector2f corner = Vector2f::Constant(std::numeric_limits<float>::infinity());
  for (const auto& triangle : result.triangles) {
    for (const auto& p : triangle) corner = corner.cwiseMin(p);
  }
  for (auto& triangle : result.triangles) {
    for (auto& p : triangle) p = (p - corner) * scale + Vector2f::Constant(static_cast<float>(rim));
  }
  trace_outline(result, rim);
  return result;
}

/// Places charts one after the other on the skyline of those before, where they come to lie
/// highest and waste least (Levy et al., "Least squares conformal maps", 2002).
class Packing {
 public:
  explicit Packing(int width_px) : skyline_(static_cast<std::size_t>(width_px), 0) {}

  Eigen::Vector2i place(const FlatChart& chart) {
    const auto width = static_cast<int>(chart.top.size());
    int best_x = 0;
    std::pair<int, long> best{std::numeric_limits<int>::max(), 0};
    for (int x = 0; x + width <= static_cast<int>(skyline_.size()); x += 2) {
      const int y = lowest_free(chart, x);
      if (y + chart.height_px > best.first) continue;
      const std::pair<int, long> here{y + chart.height_px, wasted(chart, x, y)};
      if (here < best) {
        best = here;
        best_x = x;
      }
    }
    const int y = best.first - chart.height_px;
    for (std::size_t i = 0; i < chart.top.size(); ++i) {
      if (chart.bottom[i] < 0) continue;
      skyline_[static_cast<std::size_t>(best_x) + i] = y + chart.bottom[i] + 1;
    }
    return {best_x, y};
  }

  [[nodiscard]] int height_px() const {
    return *std::max_element(skyline_.begin(), skyline_.end());
  }

 private:
  [[nodiscard]] int lowest_free(const FlatChart& chart, int x) const {
    int y = 0;
    for (std::size_t i = 0; i < chart.top.size(); ++i) {
      if (chart.bottom[i] < 0) continue;
      y = std::max(y, skyline_[static_cast<std::size_t>(x) + i] - chart.top[i]);
    }
    return y;
  }
  [[nodiscard]] long wasted(const FlatChart& chart, int x, int y) const {
    long sum = 0;
    for (std::size_t i = 0; i < chart.top.size(); ++i) {
      if (chart.bottom[i] < 0) continue;
      sum += y + chart.top[i] - skyline_[static_cast<std::size_t>(x) + i];
    }
    return sum;
  }

  std::vector<int> skyline_;
};

int rounded_up(int value, int step) {
  return (value + step - 1) / step * step;
}

int packing_width(const std::vector<FlatChart>& charts) {
  constexpr double kRoom = 1.25;  // Outlines do not close up without gaps.
  double area = 0.0;
  int widest = 0;
  for (const auto& chart : charts) {
    for (std::size_t i = 0; i < chart.top.size(); ++i) {
      if (chart.bottom[i] >= 0) area += chart.bottom[i] + 1 - chart.top[i];
    }
    widest = std::max(widest, static_cast<int>(chart.top.size()));
  }
  return rounded_up(std::max(widest, static_cast<int>(std::sqrt(kRoom * area))), 4);
}

Result<void> check_side(int side_px) {
  if (side_px <= kMaxAtlasSidePx) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("the skin's atlas would be {} px wide or high, the limit is {} px: ask for fewer "
                  "px_per_mm",
                  side_px,
                  kMaxAtlasSidePx));
}

}  // namespace

Result<void> SkinAtlasOptions::check() const {
  if (!(px_per_mm >= 0.1 && px_per_mm <= 8.0)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("px_per_mm must be in [0.1, 8], got {}", px_per_mm));
  }
  if (gutter_px < 0 || gutter_px > 64) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("gutter_px must be 0 to 64, got {}", gutter_px));
  }
  if (!(max_tilt_rad >= 0.2 && max_tilt_rad <= 1.2)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("max_tilt_rad must be in [0.2, 1.2], got {}", max_tilt_rad));
  }
  return {};
}

Result<SkinAtlas> unwrap_skin(const TriangleMesh& skin, const SkinAtlasOptions& options) {
  MOR_CHECK(options.check());
  if (skin.triangles.empty()) {
    return make_error(ErrorCode::kInvalidArgument, "a skin without triangles has no atlas");
  }
  const Eigen::Vector3f sizes_mm = skin.bounds().sizes();
  MOR_CHECK(check_side(static_cast<int>(
      std::min(0.5e9, static_cast<double>(sizes_mm.maxCoeff()) * options.px_per_mm))));
  const auto charts = internal::grow_charts(skin, options.max_tilt_rad);
  const int rim_px = (options.gutter_px + 1) / 2;
  std::vector<FlatChart> flat;
  flat.reserve(charts.size());
  for (const auto& chart : charts) {
    flat.push_back(flat_chart(skin, chart, options.px_per_mm, rim_px));
  }
  std::vector<std::size_t> order(flat.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return flat[a].height_px > flat[b].height_px;
  });
  SkinAtlas atlas;
  atlas.mesh = skin;
  atlas.px_per_mm = options.px_per_mm;
  atlas.corners_px.resize(skin.triangles.size());
  atlas.width_px = packing_width(flat);
  MOR_CHECK(check_side(atlas.width_px));
  Packing packing(atlas.width_px);
  for (const auto chart : order) {
    const Eigen::Vector2f at = packing.place(flat[chart]).cast<float>();
    for (std::size_t i = 0; i < flat[chart].triangles.size(); ++i) {
      auto& corners = atlas.corners_px[charts[chart].triangles[i]];
      corners = flat[chart].triangles[i];
      for (auto& corner : corners) corner += at;
    }
  }
  atlas.height_px = rounded_up(packing.height_px(), 4);
  MOR_CHECK(check_side(atlas.height_px));
  MOR_CHECK(atlas.check());
  return atlas;
}

}  // namespace mor
