// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/skin_charts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>

namespace mor::internal {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr std::uint32_t kNoChart = kNoTriangle;
constexpr int kRounds = 3;  ///< Of growing anew from the middles of what has grown.
constexpr std::size_t kFewTriangles = 60;
constexpr float kLeastCosineOfJoined = 0.342F;  ///< 70 degrees.

/// Grows charts over the triangles that `is_free`.
class Growth {
 public:
  Growth(const Neighbors& neighbors,
         const std::vector<Vector3f>& normals,
         const std::vector<float>& areas,
         double max_tilt_rad)
      : neighbors_(neighbors),
        normals_(normals),
        areas_(areas),
        least_cosine_(static_cast<float>(std::cos(max_tilt_rad))),
        chart_of_(normals.size(), kNoChart) {}

  void run() {
    fill_rest();
    for (int round = 0; round < kRounds; ++round) {
      regrow();
      fill_rest();
    }
    join_small();
  }

  [[nodiscard]] std::vector<SkinChart> charts() const {
    std::vector<SkinChart> result;
    std::vector<std::uint32_t> place(directions_.size(), kNoChart);
    for (std::uint32_t triangle = 0; triangle < chart_of_.size(); ++triangle) {
      auto& at = place[chart_of_[triangle]];
      if (at == kNoChart) {
        at = static_cast<std::uint32_t>(result.size());
        result.push_back({{}, directions_[chart_of_[triangle]]});
      }
      result[at].triangles.push_back(triangle);
    }
    return result;
  }

 private:
  /// (lean, triangle, chart): the least leaning first; equal ones in order, so that every run grows
  /// the same.
  using Candidate = std::tuple<float, std::uint32_t, std::uint32_t>;
  using Queue = std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>>;

  [[nodiscard]] float lean(std::uint32_t triangle, std::uint32_t chart) const {
    // A triangle without area leans nowhere: any chart may have it.
    if (normals_[triangle].isZero()) return 0.0F;
    return 1.0F - normals_[triangle].dot(directions_[chart]);
  }

  void push_neighbors(std::uint32_t triangle, std::uint32_t chart, Queue& queue) const {
    for (const auto next : neighbors_[triangle]) {
      if (next == kNoTriangle || chart_of_[next] != kNoChart) continue;
      const float leaning = lean(next, chart);
      if (leaning <= 1.0F - least_cosine_) queue.emplace(leaning, next, chart);
    }
  }

  void grow(Queue& queue) {
    while (!queue.empty()) {
      const auto [leaning, triangle, chart] = queue.top();
      queue.pop();
      if (chart_of_[triangle] != kNoChart) continue;
      chart_of_[triangle] = chart;
      push_neighbors(triangle, chart, queue);
    }
  }

  /// A new chart from each triangle that has none yet, in their order.
  void fill_rest() {
    for (std::uint32_t seed = 0; seed < chart_of_.size(); ++seed) {
      if (chart_of_[seed] != kNoChart) continue;
      const auto chart = static_cast<std::uint32_t>(directions_.size());
      directions_.push_back(normals_[seed].isZero() ? Vector3f::UnitZ() : normals_[seed]);
      Queue queue;
      queue.emplace(0.0F, seed, chart);
      grow(queue);
    }
  }

  [[nodiscard]] std::vector<Vector3f> mean_directions() const {
    std::vector<Vector3f> sums(directions_.size(), Vector3f::Zero());
    for (std::size_t i = 0; i < chart_of_.size(); ++i) {
      sums[chart_of_[i]] += areas_[i] * normals_[i];
    }
    for (std::size_t chart = 0; chart < sums.size(); ++chart) {
      const float length = sums[chart].norm();
      sums[chart] = length > 0.0F ? Vector3f(sums[chart] / length) : directions_[chart];
    }
    return sums;
  }

  /// All charts that are worth it at once, each from its most typical triangle (Cohen-Steiner,
  /// Alliez, Desbrun, "Variational shape approximation", 2004).
  void regrow() {
    const auto means = mean_directions();
    std::vector<std::size_t> count(directions_.size(), 0);
    std::vector<std::pair<float, std::uint32_t>> typical(directions_.size(), {3.0F, kNoTriangle});
    for (std::uint32_t i = 0; i < chart_of_.size(); ++i) {
      const auto chart = chart_of_[i];
      ++count[chart];
      typical[chart] = std::min(typical[chart], {1.0F - normals_[i].dot(means[chart]), i});
    }
    directions_.clear();
    std::fill(chart_of_.begin(), chart_of_.end(), kNoChart);
    Queue queue;
    for (std::size_t chart = 0; chart < count.size(); ++chart) {
      if (count[chart] < kFewTriangles) continue;
      queue.emplace(0.0F, typical[chart].second, static_cast<std::uint32_t>(directions_.size()));
      directions_.push_back(means[chart]);
    }
    grow(queue);
  }

  /// Gives the triangles of small charts, one by one from their rims, to the neighbours that they
  /// lean out of least.
  void join_small() {
    std::vector<std::size_t> count(directions_.size(), 0);
    for (const auto chart : chart_of_) ++count[chart];
    std::vector<std::uint32_t> before = chart_of_;
    for (auto& chart : chart_of_) {
      if (count[chart] < kFewTriangles) chart = kNoChart;
    }
    const float usual = std::exchange(least_cosine_, kLeastCosineOfJoined);
    Queue queue;
    for (std::uint32_t i = 0; i < chart_of_.size(); ++i) {
      if (chart_of_[i] != kNoChart) push_neighbors(i, chart_of_[i], queue);
    }
    grow(queue);
    least_cosine_ = usual;
    for (std::size_t i = 0; i < chart_of_.size(); ++i) {
      if (chart_of_[i] == kNoChart) chart_of_[i] = before[i];
    }
  }

  const Neighbors& neighbors_;
  const std::vector<Vector3f>& normals_;
  const std::vector<float>& areas_;
  float least_cosine_;
  std::vector<std::uint32_t> chart_of_;
  std::vector<Vector3f> directions_;
};

/// The chart's plane: x to the right and y down, seen from outside, the patient's head (+z of CT)
/// up where the chart does not face it.
struct Axes {
  explicit Axes(const Vector3f& normal) {
    const Vector3f up = std::abs(normal.z()) < 0.95F ? Vector3f(0, 0, 1) : Vector3f(0, -1, 0);
    down = -(up - up.dot(normal) * normal).normalized();
    right = normal.cross(down);
  }
  [[nodiscard]] Vector2f operator()(const Vector3f& p) const { return {right.dot(p), down.dot(p)}; }
  Vector3f right;
  Vector3f down;
};

/// Flat triangles by the cells of a grid that they touch.
class FlatGrid {
 public:
  explicit FlatGrid(float cell_mm) : cell_mm_(cell_mm) {}

  /// Calls `visit(cell)` for each cell that the triangle's box touches, until it returns false.
  template <class Visit>
  bool visit(const FlatTriangle& triangle, Visit visit) {
    const Vector2f low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]) / cell_mm_;
    const Vector2f high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]) / cell_mm_;
    for (int y = floor_of(low.y()); y <= floor_of(high.y()); ++y) {
      for (int x = floor_of(low.x()); x <= floor_of(high.x()); ++x) {
        const auto key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32U |
                         static_cast<std::uint32_t>(x);
        if (!visit(cells_[key])) return false;
      }
    }
    return true;
  }

 private:
  static int floor_of(float value) { return static_cast<int>(std::floor(value)); }

  float cell_mm_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// Whether an edge of `a` has all of `b` on its outer side, but for `slack`.
bool is_apart(const FlatTriangle& a, const FlatTriangle& b, float slack) {
  const auto cross = [](const Vector2f& u, const Vector2f& v) {
    return u.x() * v.y() - u.y() * v.x();
  };
  const float turn = cross(a[1] - a[0], a[2] - a[0]) < 0.0F ? -1.0F : 1.0F;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2f edge = (a[(i + 1) % 3] - a[i]).stableNormalized();
    float innermost = -std::numeric_limits<float>::infinity();
    for (const auto& p : b) innermost = std::max(innermost, turn * cross(edge, p - a[i]));
    if (innermost <= slack) return true;
  }
  return false;
}

}  // namespace

bool do_overlap(const FlatTriangle& a, const FlatTriangle& b) {
  // Rounding of coordinates up to some metres: neighbours share their edge's corners exactly.
  constexpr float kSlackMm = 2e-3F;
  return !is_apart(a, b, kSlackMm) && !is_apart(b, a, kSlackMm);
}

Neighbors triangle_neighbors(const TriangleMesh& mesh) {
  struct Side {
    std::uint64_t edge;
    std::uint32_t triangle;
    std::uint32_t corner;
    bool operator<(const Side& other) const {
      return std::tie(edge, triangle, corner) < std::tie(other.edge, other.triangle, other.corner);
    }
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      const auto [low, high] =
          std::minmax(mesh.triangles[i][corner], mesh.triangles[i][(corner + 1) % 3]);
      sides.push_back({static_cast<std::uint64_t>(low) << 32U | high, i, corner});
    }
  }
  std::sort(sides.begin(), sides.end());
  Neighbors neighbors(mesh.triangles.size(), {kNoTriangle, kNoTriangle, kNoTriangle});
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin;
    while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
    if (end - begin == 2) {
      const Side& a = sides[begin];
      const Side& b = sides[begin + 1];
      neighbors[a.triangle][a.corner] = b.triangle;
      neighbors[b.triangle][b.corner] = a.triangle;
    }
    begin = end;
  }
  return neighbors;
}

std::vector<Vector3f> triangle_normals(const TriangleMesh& mesh) {
  std::vector<Vector3f> normals;
  normals.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3f across =
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    const float length = across.norm();
    normals.emplace_back(length > 0.0F ? Vector3f(across / length) : Vector3f::Zero());
  }
  return normals;
}

std::vector<SkinChart> grow_charts(const TriangleMesh& mesh, double max_tilt_rad) {
  const auto neighbors = triangle_neighbors(mesh);
  const auto normals = triangle_normals(mesh);
  std::vector<float> areas;
  areas.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    areas.push_back(
        0.5F *
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm());
  }
  Growth growth(neighbors, normals, areas, max_tilt_rad);
  growth.run();
  auto charts = growth.charts();
  // What lies over itself when flat starts again on its own, until nothing does.
  for (std::size_t i = 0; i < charts.size(); ++i) {
    auto loose = take_overlapping(mesh, charts[i]);
    if (loose.empty()) continue;
    const Vector3f normal = charts[i].normal;
    charts.push_back({std::move(loose), normal});
  }
  return charts;
}

std::vector<FlatTriangle> laid_flat(const TriangleMesh& mesh, const SkinChart& chart) {
  const Axes axes(chart.normal);
  std::vector<FlatTriangle> flat;
  flat.reserve(chart.triangles.size());
  for (const auto triangle : chart.triangles) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    flat.push_back({axes(mesh.vertices[a]), axes(mesh.vertices[b]), axes(mesh.vertices[c])});
  }
  return flat;
}

std::vector<std::uint32_t> take_overlapping(const TriangleMesh& mesh, SkinChart& chart) {
  const auto flat = laid_flat(mesh, chart);
  FlatGrid grid(8.0F);
  std::vector<std::uint32_t> kept;
  std::vector<std::uint32_t> taken;
  for (std::uint32_t i = 0; i < flat.size(); ++i) {
    const bool is_free = grid.visit(flat[i], [&](const std::vector<std::uint32_t>& cell) {
      return std::none_of(cell.begin(), cell.end(), [&](std::uint32_t other) {
        return do_overlap(flat[i], flat[other]);
      });
    });
    if (!is_free) {
      taken.push_back(chart.triangles[i]);
      continue;
    }
    kept.push_back(chart.triangles[i]);
    grid.visit(flat[i], [&](std::vector<std::uint32_t>& cell) {
      cell.push_back(i);
      return true;
    });
  }
  chart.triangles = std::move(kept);
  return taken;
}

}  // namespace mor::internal
