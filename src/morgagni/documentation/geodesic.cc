// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/geodesic.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "morgagni/documentation/internal/sleeve.h"

namespace mor {
namespace {

using Eigen::Vector3d;
using internal::kNoTriangle;

constexpr std::uint32_t kPointsPerEdge = 3;

/// The point of a triangle that is nearest to p (Ericson, Real-Time Collision Detection, 5.1.5).
Vector3d nearest_in_triangle(const Vector3d& p,
                             const Vector3d& a,
                             const Vector3d& b,
                             const Vector3d& c) {
  const Vector3d ab = b - a;
  const Vector3d ac = c - a;
  const double d1 = ab.dot(p - a);
  const double d2 = ac.dot(p - a);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const double d3 = ab.dot(p - b);
  const double d4 = ac.dot(p - b);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(p - c);
  const double d6 = ac.dot(p - c);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return sum > 0.0 ? Vector3d(a + vb / sum * ab + vc / sum * ac) : a;
}

std::array<Vector3d, 3> corners_of(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.vertices[a].cast<double>(),
          mesh.vertices[b].cast<double>(),
          mesh.vertices[c].cast<double>()};
}

/// A* from one place of the surface to another over points on the edges.
class RowSearch {
 public:
  RowSearch(const TriangleMesh& mesh,
            const std::vector<std::array<std::uint32_t, 3>>& neighbors,
            const std::vector<std::array<std::uint32_t, 3>>& edges,
            std::uint32_t num_edges)
      : mesh_(mesh),
        neighbors_(neighbors),
        edges_(edges),
        target_(num_edges * kPointsPerEdge),
        nodes_(target_ + 1) {}

  /// The triangles on the way. Empty: there is none.
  std::vector<std::uint32_t> find(const SurfacePoint& from, const SurfacePoint& to) {
    to_ = to;
    leave(from.triangle, from.place_mm, 0.0, target_);
    while (!queue_.empty()) {
      const auto [estimate_mm, node] = queue_.top();
      queue_.pop();
      if (node == target_) return row_from(from.triangle);
      if (std::exchange(nodes_[node].is_done, true)) continue;
      // It was reached through one of the edge's two triangles, and goes on through the other.
      const Node here = nodes_[node];
      const auto& sides = edges_[here.through];
      const auto side = static_cast<std::size_t>(
          std::find(sides.begin(), sides.end(), node / kPointsPerEdge) - sides.begin());
      if (const auto behind = neighbors_[here.through][side]; behind != kNoTriangle)
        leave(behind, here.place, here.way_mm, node);
    }
    return {};
  }

 private:
  struct Node {
    double way_mm = std::numeric_limits<double>::infinity();
    Vector3d place = Vector3d::Zero();
    std::uint32_t before = 0;             ///< The node it is reached from; target_: the start.
    std::uint32_t through = kNoTriangle;  ///< The triangle it is reached through.
    bool is_done = false;
  };

  void leave(std::uint32_t triangle, const Vector3d& from, double way_mm, std::uint32_t node) {
    if (triangle == to_.triangle) reach(target_, to_.place_mm, from, way_mm, node, triangle);
    const auto corners = corners_of(mesh_, triangle);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t edge = edges_[triangle][i];
      // Both triangles of an edge number its points from the same end.
      const bool is_turned = mesh_.triangles[triangle][i] > mesh_.triangles[triangle][(i + 1) % 3];
      const Vector3d& start = corners[is_turned ? (i + 1) % 3 : i];
      const Vector3d& end = corners[is_turned ? i : (i + 1) % 3];
      for (std::uint32_t k = 0; k < kPointsPerEdge; ++k) {
        const double share = (2.0 * k + 1.0) / (2.0 * kPointsPerEdge);
        reach(
            edge * kPointsPerEdge + k, start + share * (end - start), from, way_mm, node, triangle);
      }
    }
  }

  void reach(std::uint32_t node,
             const Vector3d& place,
             const Vector3d& from,
             double way_mm,
             std::uint32_t before,
             std::uint32_t through) {
    Node& there = nodes_[node];
    const double new_way_mm = way_mm + (place - from).norm();
    if (there.is_done || new_way_mm >= there.way_mm) return;
    there = {new_way_mm, place, before, through, false};
    queue_.emplace(new_way_mm + (to_.place_mm - place).norm(), node);
  }

  std::vector<std::uint32_t> row_from(std::uint32_t first) const {
    std::vector<std::uint32_t> row;
    std::uint32_t node = target_;
    do {
      if (row.empty() || row.back() != nodes_[node].through) row.push_back(nodes_[node].through);
      node = nodes_[node].before;
    } while (node != target_);
    if (row.back() != first) row.push_back(first);
    std::reverse(row.begin(), row.end());
    return row;
  }

  using Entry = std::pair<double, std::uint32_t>;

  const TriangleMesh& mesh_;
  const std::vector<std::array<std::uint32_t, 3>>& neighbors_;
  const std::vector<std::array<std::uint32_t, 3>>& edges_;
  std::uint32_t target_;
  std::vector<Node> nodes_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
  SurfacePoint to_;
};

/// Leads the row around vertices as long as that makes the way shorter.
internal::SleevePath straighten(const internal::LinkedMesh& linked,
                                std::vector<std::uint32_t> row,
                                const Vector3d& from,
                                const Vector3d& to) {
  constexpr double kLeastGain = 1e-9;  ///< Of the length: less is rounding.
  auto path = path_in_sleeve(linked, row, from, to);
  std::size_t first_untried = 0;
  while (first_untried < path.bends.size()) {
    auto other = around_other_side(linked, row, path.bends[first_untried]);
    if (!other.empty()) {
      auto shorter = path_in_sleeve(linked, other, from, to);
      if (shorter.length_mm < path.length_mm * (1.0 - kLeastGain)) {
        path = std::move(shorter);
        row = std::move(other);
        first_untried = 0;
        continue;
      }
    }
    ++first_untried;
  }
  return path;
}

}  // namespace

Result<SurfacePoint> nearest_on_surface(const TriangleMesh& mesh, const Vector3d& point_mm) {
  if (mesh.empty() || !point_mm.allFinite()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        mesh.empty() ? "there is no surface" : "the point's coordinates are no numbers");
  }
  SurfacePoint nearest;
  double least_sq_mm2 = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = corners_of(mesh, i);
    const Vector3d place = nearest_in_triangle(point_mm, a, b, c);
    const double distance_sq_mm2 = (place - point_mm).squaredNorm();
    if (distance_sq_mm2 >= least_sq_mm2) continue;
    least_sq_mm2 = distance_sq_mm2;
    nearest = {i, place};
  }
  return nearest;
}

GeodesicMesh::GeodesicMesh(std::shared_ptr<const TriangleMesh> mesh) : mesh_(std::move(mesh)) {
  struct Side {
    std::uint32_t triangle;
    std::uint32_t corner;
    bool is_taken;
  };
  std::unordered_map<std::uint64_t, Side> open;
  open.reserve(mesh_->triangles.size() * 2);
  neighbors_.assign(mesh_->triangles.size(), {kNoTriangle, kNoTriangle, kNoTriangle});
  edges_.resize(mesh_->triangles.size());
  for (std::uint32_t triangle = 0; triangle < mesh_->triangles.size(); ++triangle) {
    const auto& corners = mesh_->triangles[triangle];
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % 3]);
      const std::uint64_t key = (std::uint64_t{low} << 32U) | high;
      const auto [found, is_new] = open.try_emplace(key, Side{triangle, i, false});
      Side& other = found->second;
      if (is_new || other.is_taken || other.triangle == triangle) {
        edges_[triangle][i] = num_edges_++;
        continue;
      }
      other.is_taken = true;
      neighbors_[triangle][i] = other.triangle;
      neighbors_[other.triangle][other.corner] = triangle;
      edges_[triangle][i] = edges_[other.triangle][other.corner];
    }
  }
}

Result<GeodesicPath> GeodesicMesh::shortest_path(const SurfacePoint& from,
                                                 const SurfacePoint& to) const {
  if (from.triangle >= neighbors_.size() || to.triangle >= neighbors_.size()) {
    return make_error(ErrorCode::kInvalidArgument, "the point is not on the surface");
  }
  if (from.triangle == to.triangle) {
    return GeodesicPath{(to.place_mm - from.place_mm).norm(), {from.place_mm, to.place_mm}};
  }
  auto row = RowSearch(*mesh_, neighbors_, edges_, num_edges_).find(from, to);
  if (row.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "there is no way over the skin from one point to the other: they lie on "
                      "parts that do not hang together");
  }
  auto path = straighten({*mesh_, neighbors_}, std::move(row), from.place_mm, to.place_mm);
  return GeodesicPath{path.length_mm, std::move(path.points_mm)};
}

}  // namespace mor
