// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/skin_atlas.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/documentation/internal/skin_charts.h"

namespace mor {
namespace {

using ::testing::HasSubstr;

/// A closed wavy ball: it faces every way, and folds over itself when laid flat.
TriangleMesh wavy_ball(int rings, float wave) {
  TriangleMesh mesh;
  const auto at = [rings](int ring, int column) {
    return static_cast<std::uint32_t>(ring * rings + column % rings);
  };
  for (int ring = 0; ring <= rings; ++ring) {
    for (int column = 0; column < rings; ++column) {
      const float polar =
          std::numbers::pi_v<float> * static_cast<float>(ring) / static_cast<float>(rings);
      const float around =
          2.0F * std::numbers::pi_v<float> * static_cast<float>(column) / static_cast<float>(rings);
      const float radius = 90.0F + wave * std::sin(6.0F * around) * std::sin(5.0F * polar);
      mesh.vertices.emplace_back(radius * Eigen::Vector3f(std::sin(polar) * std::cos(around),
                                                          std::sin(polar) * std::sin(around),
                                                          std::cos(polar)));
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int column = 0; column < rings; ++column) {
      const auto a = at(ring, column);
      const auto b = at(ring + 1, column);
      const auto c = at(ring + 1, column + 1);
      const auto d = at(ring, column + 1);
      if (ring + 1 < rings) mesh.triangles.push_back({a, b, c});
      if (ring > 0) mesh.triangles.push_back({a, c, d});
    }
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

float cross(const Eigen::Vector2f& u, const Eigen::Vector2f& v) {
  return u.x() * v.y() - u.y() * v.x();
}

/// How many triangles have each texel's centre inside, well away from their edges.
Image<int> cover(const SkinAtlas& atlas) {
  Image<int> count(atlas.width_px, atlas.height_px, 0);
  for (const auto& [a, b, c] : atlas.corners_px) {
    const float turn = cross(b - a, c - a) < 0.0F ? -1.0F : 1.0F;
    const Eigen::Vector2f low = a.cwiseMin(b).cwiseMin(c);
    const Eigen::Vector2f high = a.cwiseMax(b).cwiseMax(c);
    for (int y = static_cast<int>(low.y()); y <= static_cast<int>(high.y()) + 1; ++y) {
      for (int x = static_cast<int>(low.x()); x <= static_cast<int>(high.x()) + 1; ++x) {
        if (!count.view().contains(x, y)) continue;
        const Eigen::Vector2f p(static_cast<float>(x), static_cast<float>(y));
        const auto inside = [&](const Eigen::Vector2f& from, const Eigen::Vector2f& to) {
          return turn * cross((to - from).normalized(), p - from) > 0.02F;
        };
        if (inside(a, b) && inside(b, c) && inside(c, a)) ++count(x, y);
      }
    }
  }
  return count;
}

TEST(SkinAtlas, UnwrapsWithoutOverlap) {
  const auto atlas = unwrap_skin(wavy_ball(80, 14.0F), {});
  ASSERT_TRUE(atlas.has_value()) << atlas.error().message;
  ASSERT_TRUE(atlas->check().has_value());
  const auto count = cover(*atlas);
  int most = 0;
  long covered = 0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    most = std::max(most, count.data()[i]);
    covered += count.data()[i] > 0 ? 1 : 0;
  }
  EXPECT_EQ(most, 1);
  // Most of the skin's square millimetres have their texel: nothing was left out.
  EXPECT_GT(static_cast<double>(covered), 0.85 * surface_area_mm2(atlas->mesh));
}

TEST(SkinAtlas, StretchesLittleAndNeverMirrors) {
  const double px_per_mm = 1.6;
  const auto atlas = unwrap_skin(wavy_ball(80, 8.0F), {.px_per_mm = px_per_mm});
  ASSERT_TRUE(atlas.has_value());
  double within = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < atlas->corners_px.size(); ++i) {
    const auto& [ia, ib, ic] = atlas->mesh.triangles[i];
    const auto& v = atlas->mesh.vertices;
    const double area_mm2 = 0.5 * (v[ib] - v[ia]).cross(v[ic] - v[ia]).norm();
    const auto& [a, b, c] = atlas->corners_px[i];
    // Counter-clockwise from outside is clockwise where rows run down.
    const double area_px = -0.5 * cross(b - a, c - a);
    EXPECT_GT(area_px, 0.0) << i;
    const double scale = std::sqrt(area_px / area_mm2) / px_per_mm;
    total += area_mm2;
    if (scale > 0.85 && scale < 1.15) within += area_mm2;
  }
  EXPECT_GT(within, 0.95 * total);
}

TEST(SkinAtlas, KeepsAGutterBetweenCharts) {
  const auto mesh = wavy_ball(60, 4.0F);
  const auto atlas = unwrap_skin(mesh, {.gutter_px = 6});
  ASSERT_TRUE(atlas.has_value());
  // Grown by 2 px to each side, triangles that are no neighbours by a corner stay apart.
  const auto charts = internal::grow_charts(mesh, SkinAtlasOptions{}.max_tilt_rad);
  ASSERT_GT(charts.size(), 4U);
  Image<int> owner(atlas->width_px, atlas->height_px, -1);
  int clashes = 0;
  for (std::size_t chart = 0; chart < charts.size(); ++chart) {
    for (const auto triangle : charts[chart].triangles) {
      for (const auto& corner : atlas->corners_px[triangle]) {
        for (int y = static_cast<int>(corner.y()) - 2; y <= static_cast<int>(corner.y()) + 2; ++y) {
          for (int x = static_cast<int>(corner.x()) - 2; x <= static_cast<int>(corner.x()) + 2;
               ++x) {
            ASSERT_TRUE(owner.view().contains(x, y));
            if (owner(x, y) >= 0 && owner(x, y) != static_cast<int>(chart)) ++clashes;
            owner(x, y) = static_cast<int>(chart);
          }
        }
      }
    }
  }
  EXPECT_EQ(clashes, 0);
}

TEST(SkinAtlas, IsTheSameEveryTime) {
  const auto first = unwrap_skin(wavy_ball(40, 10.0F), {});
  const auto second = unwrap_skin(wavy_ball(40, 10.0F), {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->corners_px, second->corners_px);
  EXPECT_EQ(first->height_px, second->height_px);
}

TEST(SkinAtlas, TakesHolesFansAndTrianglesWithoutArea) {
  auto mesh = wavy_ball(30, 10.0F);
  mesh.triangles.erase(mesh.triangles.begin() + 100, mesh.triangles.begin() + 160);
  mesh.triangles.push_back({5, 5, 9});            // No area.
  mesh.triangles.push_back(mesh.triangles[300]);  // The same twice: an edge of three.
  const auto [a, b, c] = mesh.triangles[400];
  mesh.triangles.push_back({a, c, b});  // And one from behind.
  const auto atlas = unwrap_skin(mesh, {});
  ASSERT_TRUE(atlas.has_value()) << atlas.error().message;
  const auto count = cover(*atlas);
  EXPECT_EQ(*std::max_element(count.data(), count.data() + count.size()), 1);
}

TEST(SkinAtlas, RefusesWhatItCannotDo) {
  EXPECT_FALSE(unwrap_skin({}, {}).has_value());
  const auto fine = unwrap_skin(wavy_ball(10, 0.0F), {.px_per_mm = 9.0});
  ASSERT_FALSE(fine.has_value());
  EXPECT_THAT(fine.error().message, HasSubstr("px_per_mm must be in [0.1, 8], got 9"));
  auto huge = wavy_ball(10, 0.0F);
  for (auto& vertex : huge.vertices) vertex *= 100.0F;
  const auto refused = unwrap_skin(huge, {});
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("the limit is 8192 px"));
}

TEST(FlatTriangles, OverlapOnlyWhereTheyShareMoreThanAnEdge) {
  const internal::FlatTriangle base = {
      Eigen::Vector2f(0, 0), Eigen::Vector2f(10, 0), Eigen::Vector2f(0, 10)};
  const auto other = [](float ax, float ay, float bx, float by, float cx, float cy) {
    return internal::FlatTriangle{
        Eigen::Vector2f(ax, ay), Eigen::Vector2f(bx, by), Eigen::Vector2f(cx, cy)};
  };
  EXPECT_FALSE(internal::do_overlap(base, other(10, 0, 10, 10, 0, 10)));
  EXPECT_FALSE(internal::do_overlap(base, other(0, 0, -5, 0, 0, -5)));
  EXPECT_TRUE(internal::do_overlap(base, other(10, 0, 0, 10, 1, 1)));
  EXPECT_TRUE(internal::do_overlap(base, base));
  EXPECT_TRUE(internal::do_overlap(base, other(1, 1, 2, 1, 1, 2)));
}

}  // namespace
}  // namespace mor
