// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/sleeve.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

namespace mor::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// An edge between two triangles of the row, unfolded into the plane; sides as seen on the way.
struct Portal {
  Vector2d left;
  Vector2d right;
  std::uint32_t left_vertex = 0;
  std::uint32_t right_vertex = 0;
};

struct Unfolded {
  std::vector<Portal> portals;
  Vector2d from;
  Vector2d to;
};

/// A vertex of the mesh with its place in the plane.
struct Placed {
  std::uint32_t vertex = 0;
  Vector2d at = Vector2d::Zero();
};
using PlacedTriangle = std::array<Placed, 3>;

Vector3d place_of(const TriangleMesh& mesh, std::uint32_t vertex) {
  return mesh.vertices[vertex].cast<double>();
}

/// Where a point lies in the plane in which a and b lie already: on the side of `side` (+1: to the
/// left of the way from a to b).
Vector2d unfold(const TriangleMesh& mesh,
                const Placed& a,
                const Placed& b,
                const Vector3d& point,
                double side) {
  const Vector3d ab = place_of(mesh, b.vertex) - place_of(mesh, a.vertex);
  const Vector3d ap = point - place_of(mesh, a.vertex);
  const double length = ab.norm();
  const Vector2d along = (b.at - a.at).stableNormalized();
  if (length <= 0.0) return a.at + ap.norm() * Vector2d(-along.y(), along.x());
  const double x = ap.dot(ab) / length;
  const double y = ab.cross(ap).norm() / length;
  return a.at + x * along + side * y * Vector2d(-along.y(), along.x());
}

PlacedTriangle place_first(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& corners = mesh.triangles[triangle];
  PlacedTriangle placed;
  for (std::size_t i = 0; i < 3; ++i) placed[i].vertex = corners[i];
  placed[1].at = {(place_of(mesh, corners[1]) - place_of(mesh, corners[0])).norm(), 0.0};
  placed[2].at = unfold(mesh, placed[0], placed[1], place_of(mesh, corners[2]), 1.0);
  return placed;
}

/// A point of the placed triangle, in the plane: by its weights at the corners, which the plane
/// keeps.
Vector2d place_in(const TriangleMesh& mesh, const PlacedTriangle& triangle, const Vector3d& point) {
  const Vector3d a = place_of(mesh, triangle[0].vertex);
  const Vector3d ab = place_of(mesh, triangle[1].vertex) - a;
  const Vector3d ac = place_of(mesh, triangle[2].vertex) - a;
  const Vector3d normal = ab.cross(ac);
  const double area_sq = normal.squaredNorm();
  if (area_sq <= 0.0) return triangle[0].at;
  const double v = (point - a).cross(ac).dot(normal) / area_sq;
  const double w = ab.cross(point - a).dot(normal) / area_sq;
  return triangle[0].at + v * (triangle[1].at - triangle[0].at) +
         w * (triangle[2].at - triangle[0].at);
}

std::size_t edge_to(const LinkedMesh& linked, std::uint32_t triangle, std::uint32_t next) {
  const auto& neighbors = linked.neighbors[triangle];
  return static_cast<std::size_t>(std::find(neighbors.begin(), neighbors.end(), next) -
                                  neighbors.begin());
}

Unfolded unfold_row(const LinkedMesh& linked,
                    const std::vector<std::uint32_t>& row,
                    const Vector3d& from,
                    const Vector3d& to) {
  const TriangleMesh& mesh = linked.mesh;
  Unfolded result;
  PlacedTriangle here = place_first(mesh, row.front());
  result.from = place_in(mesh, here, from);
  for (std::size_t i = 0; i + 1 < row.size(); ++i) {
    const std::size_t edge = edge_to(linked, row[i], row[i + 1]);
    const auto& corners = mesh.triangles[row[i]];
    const auto placed = [&](std::uint32_t vertex) {
      return *std::find_if(
          here.begin(), here.end(), [&](const Placed& each) { return each.vertex == vertex; });
    };
    const Placed a = placed(corners[edge]);
    const Placed b = placed(corners[(edge + 1) % 3]);
    const Placed behind = placed(corners[(edge + 2) % 3]);
    const double side = cross(b.at - a.at, behind.at - a.at) >= 0.0 ? -1.0 : 1.0;
    // Who looks from what lies to the left of the way from a to b has b on the left hand.
    result.portals.push_back(side < 0.0 ? Portal{b.at, a.at, b.vertex, a.vertex}
                                        : Portal{a.at, b.at, a.vertex, b.vertex});
    const auto& next = mesh.triangles[row[i + 1]];
    const std::uint32_t ahead = *std::find_if(
        next.begin(), next.end(), [&](std::uint32_t v) { return v != a.vertex && v != b.vertex; });
    here = {a, b, {ahead, unfold(mesh, a, b, place_of(mesh, ahead), side)}};
  }
  result.to = place_in(mesh, here, to);
  return result;
}

/// A point that the way goes through, and from which portal on it does.
struct Knot {
  Vector2d at;
  std::size_t portal = 0;
  std::optional<std::uint32_t> vertex;
};

/// The funnel: both of its sides are drawn tight portal by portal; where one would cross the other,
/// the way bends there and the funnel begins anew.
std::vector<Knot> pull_tight(const Unfolded& unfolded) {
  const auto& portals = unfolded.portals;
  std::vector<Knot> knots = {{unfolded.from, 0, std::nullopt}};
  Knot left = knots.front();
  Knot right = knots.front();
  for (std::size_t i = 0; i <= portals.size(); ++i) {
    const bool is_end = i == portals.size();
    const Vector2d apex = knots.back().at;
    const Knot new_left{is_end ? unfolded.to : portals[i].left,
                        i,
                        is_end ? std::nullopt : std::optional(portals[i].left_vertex)};
    const Knot new_right{is_end ? unfolded.to : portals[i].right,
                         i,
                         is_end ? std::nullopt : std::optional(portals[i].right_vertex)};
    const auto turn = [&](const Knot& a, const Knot& b) { return cross(a.at - apex, b.at - apex); };
    std::optional<Knot> bend;
    if (turn(right, new_right) >= 0.0) {
      if (right.at == apex || turn(new_right, left) > 0.0) {
        right = new_right;
      } else {
        bend = left;
      }
    }
    if (!bend && turn(new_left, left) >= 0.0) {
      if (left.at == apex || turn(right, new_left) > 0.0) {
        left = new_left;
      } else {
        bend = right;
      }
    }
    if (!bend) continue;
    if (!bend->vertex) break;  // The end itself: the way runs straight into it.
    knots.push_back(*bend);
    left = right = *bend;
    i = bend->portal;
  }
  knots.push_back({unfolded.to, portals.size(), std::nullopt});
  return knots;
}

/// Where the way from a to b goes through a portal: 0 at its left end, 1 at its right.
double share_at(const Portal& portal, const Vector2d& a, const Vector2d& b) {
  const double left = cross(b - a, portal.left - a);
  const double right = cross(b - a, portal.right - a);
  return std::abs(left - right) > 0.0 ? std::clamp(left / (left - right), 0.0, 1.0) : 0.5;
}

/// No triangle twice: a shortest way enters each once.
void cut_loops(std::vector<std::uint32_t>& row) {
  std::unordered_map<std::uint32_t, std::size_t> last;
  for (std::size_t i = 0; i < row.size(); ++i) last[row[i]] = i;
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < row.size(); ++i) {
    kept.push_back(row[i]);
    i = last[row[i]];
  }
  row = std::move(kept);
}

bool has_vertex(const TriangleMesh& mesh, std::uint32_t triangle, std::uint32_t vertex) {
  const auto& corners = mesh.triangles[triangle];
  return std::find(corners.begin(), corners.end(), vertex) != corners.end();
}

}  // namespace

SleevePath path_in_sleeve(const LinkedMesh& linked,
                          const std::vector<std::uint32_t>& row,
                          const Vector3d& from,
                          const Vector3d& to) {
  const Unfolded unfolded = unfold_row(linked, row, from, to);
  const std::vector<Knot> knots = pull_tight(unfolded);
  SleevePath path;
  path.points_mm.push_back(from);
  std::size_t portal = 0;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const Knot& start = knots[k];
    const Knot& end = knots[k + 1];
    path.length_mm += (end.at - start.at).norm();
    if (start.vertex) path.bends.push_back({*start.vertex, start.portal});
    for (; portal < unfolded.portals.size() && portal <= end.portal; ++portal) {
      const Portal& edge = unfolded.portals[portal];
      const double share = share_at(edge, start.at, end.at);
      path.points_mm.emplace_back((1.0 - share) * place_of(linked.mesh, edge.left_vertex) +
                                  share * place_of(linked.mesh, edge.right_vertex));
    }
  }
  path.points_mm.push_back(to);
  return path;
}

std::vector<std::uint32_t> around_other_side(const LinkedMesh& linked,
                                             const std::vector<std::uint32_t>& row,
                                             const Bend& bend) {
  const TriangleMesh& mesh = linked.mesh;
  // The stretch of the row that turns around the vertex.
  std::size_t first = bend.portal;
  std::size_t last = bend.portal + 1;
  while (first > 0 && has_vertex(mesh, row[first - 1], bend.vertex)) --first;
  while (last + 1 < row.size() && has_vertex(mesh, row[last + 1], bend.vertex)) ++last;

  std::vector<std::uint32_t> other(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(first));
  std::uint32_t before = row[first + 1];
  std::uint32_t here = row[first];
  while (here != row[last]) {
    other.push_back(here);
    const auto& corners = mesh.triangles[here];
    std::uint32_t next = kNoTriangle;
    for (std::size_t i = 0; i < 3; ++i) {
      const bool ends_here = corners[i] == bend.vertex || corners[(i + 1) % 3] == bend.vertex;
      if (ends_here && linked.neighbors[here][i] != before) next = linked.neighbors[here][i];
    }
    if (next == kNoTriangle || other.size() > row.size() + mesh.triangles.size()) return {};
    before = std::exchange(here, next);
  }
  other.insert(other.end(), row.begin() + static_cast<std::ptrdiff_t>(last), row.end());
  cut_loops(other);
  return other;
}

}  // namespace mor::internal
