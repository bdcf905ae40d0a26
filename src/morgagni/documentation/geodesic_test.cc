// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/geodesic.h"

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using MeshPtr = std::shared_ptr<const TriangleMesh>;

/// A grid of crooked triangles with z = height(x, y), 2 mm wide each, without the squares that
/// `is_left_out` names.
MeshPtr sheet(
    int side,
    const std::function<double(double, double)>& height,
    const std::function<bool(int, int)>& is_left_out = [](int, int) { return false; }) {
  auto mesh = std::make_shared<TriangleMesh>();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-0.6, 0.6);
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x) {
      const bool is_inside = x > 0 && y > 0 && x < side && y < side;
      const double px = 2.0 * x + (is_inside ? jitter(random) : 0.0);
      const double py = 2.0 * y + (is_inside ? jitter(random) : 0.0);
      mesh->vertices.push_back(Vector3d(px, py, height(px, py)).cast<float>());
    }
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      if (is_left_out(x, y)) continue;
      const auto at = [&](int i, int j) {
        return static_cast<std::uint32_t>((y + j) * (side + 1) + x + i);
      };
      if ((x * 7 + y * 3) % 5 < 2) {
        mesh->triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
        mesh->triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
      } else {
        mesh->triangles.push_back({at(0, 0), at(1, 0), at(0, 1)});
        mesh->triangles.push_back({at(1, 0), at(1, 1), at(0, 1)});
      }
    }
  }
  return mesh;
}

double flat(double, double) {
  return 0.0;
}

/// An octahedron, each triangle halved again and again and put on the sphere.
MeshPtr sphere(double radius_mm, int num_halvings) {
  auto mesh = std::make_shared<TriangleMesh>();
  std::vector<Vector3d> places = {
      {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh->triangles = {
      {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int round = 0; round < num_halvings; ++round) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(places.size()));
      if (is_new) places.push_back((places[a] + places[b]).normalized());
      return found->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh->triangles) {
      const auto ab = middle(a, b);
      const auto bc = middle(b, c);
      const auto ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh->triangles = std::move(finer);
  }
  for (const auto& place : places) mesh->vertices.push_back((radius_mm * place).cast<float>());
  return mesh;
}

Result<GeodesicPath> way(const GeodesicMesh& surface, const Vector3d& a, const Vector3d& b) {
  MOR_TRY(const auto from, nearest_on_surface(surface.mesh(), a));
  MOR_TRY(const auto to, nearest_on_surface(surface.mesh(), b));
  return surface.shortest_path(from, to);
}

double length_of(const std::vector<Vector3d>& points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

/// An upper bound by another way of reckoning: Dijkstra over the vertices and `count` points of
/// each edge, all points of a triangle joined.
double dense_length(const TriangleMesh& mesh, std::uint32_t from, std::uint32_t to, int count) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::size_t>> on_edge;
  std::vector<Vector3d> places;
  for (const auto& vertex : mesh.vertices) places.push_back(vertex.cast<double>());
  std::vector<std::vector<std::size_t>> of_triangle;
  for (const auto& corners : mesh.triangles) {
    std::vector<std::size_t> all(corners.begin(), corners.end());
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % 3]);
      auto& points = on_edge[{low, high}];
      for (int k = 1; points.size() < static_cast<std::size_t>(count); ++k) {
        points.push_back(places.size());
        places.emplace_back(places[low] + k / (count + 1.0) * (places[high] - places[low]));
      }
      all.insert(all.end(), points.begin(), points.end());
    }
    of_triangle.push_back(std::move(all));
  }
  std::vector<std::vector<std::size_t>> triangles_at(places.size());
  for (std::size_t t = 0; t < of_triangle.size(); ++t)
    for (const auto node : of_triangle[t]) triangles_at[node].push_back(t);
  std::vector<double> best(places.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<std::pair<double, std::size_t>,
                      std::vector<std::pair<double, std::size_t>>,
                      std::greater<>>
      queue;
  queue.emplace(best[from] = 0.0, from);
  while (!queue.empty()) {
    const auto [length, node] = queue.top();
    queue.pop();
    if (node == to) return length;
    if (length > best[node]) continue;
    for (const auto t : triangles_at[node]) {
      for (const auto next : of_triangle[t]) {
        const double there = length + (places[next] - places[node]).norm();
        if (there < best[next]) queue.emplace(best[next] = there, next);
      }
    }
  }
  return best[to];
}

TEST(Geodesic, IsTheStraightWayOnAPlane) {
  const GeodesicMesh surface(sheet(40, flat));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.5, 79.5);
  for (int i = 0; i < 60; ++i) {
    const Vector3d a(place(random), place(random), 0.0);
    const Vector3d b(place(random), place(random), 0.0);
    const auto path = way(surface, a, b);
    ASSERT_TRUE(path) << path.error().message;
    EXPECT_NEAR(path->length_mm, (b - a).norm(), 1e-9 * 80.0);
    EXPECT_NEAR(length_of(path->points_mm), path->length_mm, 1e-9 * 80.0);
  }
}

TEST(Geodesic, IsAGreatCircleOnASphere) {
  constexpr double kRadiusMm = 100.0;
  const GeodesicMesh surface(sphere(kRadiusMm, 5));
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  for (int i = 0; i < 60; ++i) {
    const Vector3d a = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Vector3d b = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const double truth_mm = kRadiusMm * std::atan2(a.cross(b).norm(), a.dot(b));
    const auto path = way(surface, kRadiusMm * a, kRadiusMm * b);
    ASSERT_TRUE(path) << path.error().message;
    worst = std::max(worst, std::abs(path->length_mm - truth_mm) / truth_mm);
    EXPECT_NEAR(length_of(path->points_mm), path->length_mm, 1e-6);
  }
  EXPECT_LT(worst, 0.005);
  RecordProperty("worst_relative_error", std::to_string(worst));
}

TEST(Geodesic, IsTheUnrolledStraightWayOnACylinder) {
  // A sheet rolled about the y axis keeps its lengths but for the triangles' chords.
  constexpr double kRadiusMm = 30.0;
  auto rolled = std::make_shared<TriangleMesh>(*sheet(60, flat));
  for (auto& v : rolled->vertices) {
    const double angle = static_cast<double>(v.x()) / kRadiusMm;
    v = Vector3d(kRadiusMm * std::sin(angle), v.y(), kRadiusMm * std::cos(angle)).cast<float>();
  }
  const GeodesicMesh surface(rolled);
  const auto on = [&](double x, double y) {
    const double angle = x / kRadiusMm;
    return Vector3d(kRadiusMm * std::sin(angle), y, kRadiusMm * std::cos(angle));
  };
  const auto path = way(surface, on(10, 15), on(85, 100));
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length_mm, std::hypot(75.0, 85.0), 0.003 * path->length_mm);
}

TEST(Geodesic, GoesAroundAHole) {
  // Squares 10..19 are left out: the corners of the hole are near (20, 20) and (40, 40).
  const auto holed =
      sheet(30, flat, [](int x, int y) { return x >= 10 && x < 20 && y >= 10 && y < 20; });
  const GeodesicMesh surface(holed);
  const auto vertex = [&](int x, int y) {
    return Vector3d(holed->vertices[static_cast<std::size_t>(y * 31 + x)].cast<double>());
  };
  const Vector3d a = vertex(12, 6);
  const Vector3d b = vertex(24, 18);
  const auto path = way(surface, a, b);
  ASSERT_TRUE(path);
  // Around the corner (20, 10), whose exact place and neighbours the crooked grid decides.
  const double around = (vertex(20, 10) - a).norm() + (b - vertex(20, 10)).norm();
  EXPECT_NEAR(path->length_mm, around, 0.01 * around);
  EXPECT_LE(path->length_mm, dense_length(*holed, 6 * 31 + 12, 18 * 31 + 24, 12) * (1 + 1e-9));
}

TEST(Geodesic, IsNoLongerThanADenseSearchOnABumpySheet) {
  const auto bumpy = sheet(24, [](double x, double y) {
    return 5.0 * std::sin(x / 4.0) * std::cos(y / 5.0) +
           8.0 * std::exp(-(x - 24) * (x - 24) / 60.0);
  });
  const GeodesicMesh surface(bumpy);
  std::mt19937 random(11);
  std::uniform_int_distribution<std::uint32_t> any(0, 24);
  for (int i = 0; i < 12; ++i) {
    const std::uint32_t from = any(random) * 25 + any(random) % 6;
    const std::uint32_t to = any(random) * 25 + 18 + any(random) % 6;
    const auto path =
        way(surface, bumpy->vertices[from].cast<double>(), bumpy->vertices[to].cast<double>());
    ASSERT_TRUE(path);
    const double dense = dense_length(*bumpy, from, to, 12);
    EXPECT_LE(path->length_mm, dense * (1.0 + 1e-6)) << from << " to " << to;
    EXPECT_GE(path->length_mm, dense * 0.995) << from << " to " << to;
  }
}

TEST(Geodesic, HasBothEndsAndStaysOnTheSurface) {
  const auto ball = sphere(50.0, 4);
  const GeodesicMesh surface(ball);
  const auto path = way(surface, {50, 1, 2}, {-30, -40, 5});
  ASSERT_TRUE(path);
  for (const auto& point : path->points_mm) {
    const auto nearest = nearest_on_surface(*ball, point).value();
    EXPECT_LT((nearest.place_mm - point).norm(), 1e-4);
  }
  const auto back = way(surface, {-30, -40, 5}, {50, 1, 2});
  EXPECT_NEAR(back->length_mm, path->length_mm, 1e-6);
}

TEST(Geodesic, WithinOneTriangleAndOnOnePlaceItIsTheStraightWay) {
  const GeodesicMesh surface(sheet(4, flat));
  EXPECT_NEAR(way(surface, {1, 0.5, 0}, {1.2, 0.5, 0})->length_mm, 0.2, 1e-6);
  EXPECT_EQ(way(surface, {3, 3, 0}, {3, 3, 0})->length_mm, 0.0);
}

TEST(Geodesic, SaysThatPartsDoNotHangTogether) {
  const auto one = sheet(4, flat);
  auto two = std::make_shared<TriangleMesh>(*one);
  const auto num = static_cast<std::uint32_t>(one->vertices.size());
  for (const auto& v : one->vertices) two->vertices.push_back(v + Eigen::Vector3f(0, 0, 50));
  for (const auto& [a, b, c] : one->triangles)
    two->triangles.push_back({a + num, b + num, c + num});
  const auto refused = way(GeodesicMesh(two), {1, 1, 0}, {1, 1, 50});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("do not hang together"));
}

TEST(Geodesic, TakesMeshesThatAreNoSurfaces) {
  // Three sheets at one edge, a triangle without area, and one that is there twice.
  auto odd = std::make_shared<TriangleMesh>();
  odd->vertices = {{0, 0, 0}, {10, 0, 0}, {5, 10, 0}, {5, -10, 0}, {5, 0, 10}, {5, 0, 0}};
  odd->triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 1, 5}, {0, 1, 2}};
  const GeodesicMesh surface(odd);
  const auto path = way(surface, {5, 8, 0}, {5, -8, 0});
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_NEAR(path->length_mm, 16.0, 1e-6);
}

TEST(Geodesic, RefusesPointsThatAreNone) {
  const auto mesh = sheet(4, flat);
  EXPECT_FALSE(nearest_on_surface(*mesh, Vector3d(std::nan(""), 0, 0)));
  EXPECT_FALSE(nearest_on_surface(TriangleMesh(), {0, 0, 0}));
  EXPECT_FALSE(GeodesicMesh(mesh).shortest_path({1'000'000, {0, 0, 0}}, {0, {0, 0, 0}}));
}

}  // namespace
}  // namespace mor
