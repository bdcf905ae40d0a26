// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/clutter.h"

#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "morgagni/camera/internal/scene/blended_solid.h"
#include "morgagni/camera/internal/scene/shade_map.h"
#include "morgagni/camera/internal/scene/sweep.h"

namespace mor::internal {
namespace {

using Eigen::Vector3f;

constexpr float kTableMm = 110.0F;

/// A lying trunk, 360 x 220 x 300 mm, open where a CT would end, its back on the table.
TriangleMesh trunk() {
  TriangleMesh mesh;
  constexpr unsigned kAround = 120;
  constexpr unsigned kAlong = 50;
  for (unsigned row = 0; row <= kAlong; ++row) {
    for (unsigned column = 0; column < kAround; ++column) {
      const double angle_rad = 2.0 * std::numbers::pi * column / kAround;
      mesh.vertices.emplace_back(static_cast<float>(180.0 * std::cos(angle_rad)),
                                 static_cast<float>(110.0 * std::sin(angle_rad)),
                                 6.0F * static_cast<float>(row));
    }
  }
  for (unsigned row = 0; row < kAlong; ++row) {
    for (unsigned column = 0; column < kAround; ++column) {
      const unsigned next = (column + 1) % kAround;
      const unsigned a = row * kAround + column;
      const unsigned b = row * kAround + next;
      mesh.triangles.push_back({a, b, a + kAround});
      mesh.triangles.push_back({b, b + kAround, a + kAround});
    }
  }
  return mesh;
}

/// Every edge once in each direction.
bool is_closed(const TriangleMesh& mesh) {
  return boundary_loops(mesh, 0.0F).empty();
}

float least_height_mm(const TriangleMesh& mesh) {
  float least = kTableMm;
  for (const auto& p : mesh.vertices) least = std::min(least, kTableMm - p.y());
  return least;
}

TEST(BlendedSurface, IsClosedAndLiesARadiusAroundALimb) {
  const auto ball =
      blended_surface({{Vector3f::Zero(), {30.0F, 0.0F, 0.0F}, 20.0F, 20.0F}}, 5.0F, 3.0F);
  EXPECT_TRUE(is_closed(ball));
  for (std::size_t i = 0; i < ball.vertices.size(); ++i) {
    const Vector3f& p = ball.vertices[i];
    const Vector3f axis(std::clamp(p.x(), 0.0F, 30.0F), 0.0F, 0.0F);
    ASSERT_NEAR((p - axis).norm(), 20.0F, 0.5F);
    ASSERT_GT(ball.normals[i].dot((p - axis).normalized()), 0.9F);
  }
}

TEST(Sweep, ATubeIsClosedButForItsBeginAndFacesOutwards) {
  const auto mesh = tube(Vector3f::Zero(), {0.0F, 0.0F, 100.0F}, 30.0F, 20.0F);
  const auto normals = vertex_normals(mesh);
  const auto loops = boundary_loops(mesh, 100.0F);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_NEAR(loops[0].length_mm, 2.0F * std::numbers::pi_v<float> * 30.0F, 1.0F);
  EXPECT_LT((loops[0].outward + Vector3f::UnitZ()).norm(), 1e-3F);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3f radial(mesh.vertices[i].x(), mesh.vertices[i].y(), 0.0F);
    if (radial.norm() > 10.0F) ASSERT_GT(normals[i].dot(radial.normalized()), 0.5F);
  }
}

TEST(BoundaryLoops, AreTheCutsOfABody) {
  const auto loops = boundary_loops(trunk(), 60.0F);
  ASSERT_EQ(loops.size(), 2U);
  for (const auto& loop : loops) {
    EXPECT_EQ(loop.points.size(), 120U);
    const bool is_upper = loop.center.z() > 150.0F;
    EXPECT_NEAR(loop.outward.z(), is_upper ? 1.0F : -1.0F, 1e-3F);
  }
}

TEST(BodyBeyond, BeginsAtTheCutsAndStaysOnTheTable) {
  const auto skin = trunk();
  const BodyBeyond beyond(skin, kTableMm);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Draws draw(scramble(seed));
    const auto parts = beyond.continued(draw);
    EXPECT_GE(least_height_mm(parts.mesh), 0.0F);
    const auto bounds = parts.mesh.bounds();
    EXPECT_GT(bounds.max().z(), 500.0F);   // The head.
    EXPECT_LT(bounds.min().z(), -450.0F);  // The thighs.
    float nearest_mm = 1e9F;
    for (const auto& p : parts.mesh.vertices) {
      nearest_mm = std::min(nearest_mm, (p - skin.vertices.front()).norm());
    }
    EXPECT_LT(nearest_mm, 5.0F);
  }
}

TEST(BodyBeyond, AddsNothingToAClosedSkin) {
  const auto ball =
      blended_surface({{Vector3f::Zero(), Vector3f::UnitX(), 80.0F, 80.0F}}, 5.0F, 8.0F);
  Draws draw(1);
  EXPECT_TRUE(BodyBeyond(ball, 80.0F).continued(draw).mesh.empty());
}

TEST(Clutter, TowelLiesOverTheBodyAndNeverInIt) {
  const auto skin = trunk();
  const Clutter clutter(skin, kTableMm, SimulatedClutter::kTowel, true, 4);
  int num_over_body = 0;
  for (std::uint64_t id = 0; id < 10; ++id) {
    const auto towel = clutter.at(id, 0.0);
    ASSERT_FALSE(towel.mesh.empty());
    EXPECT_GT(least_height_mm(towel.mesh), 2.0F);
    for (const auto& p : towel.mesh.vertices) {
      if (p.z() < 8.0F || p.z() > 292.0F || std::abs(p.x()) > 172.0F) continue;
      const float share = p.x() / 180.0F;
      const float skin_mm = -110.0F * std::sqrt(1.0F - share * share);
      // Up is -y; the height map knows the skin in cells of 6 mm.
      ASSERT_LT(p.y(), skin_mm + (std::abs(p.x()) < 140.0F ? 2.0F : 12.0F));
      ++num_over_body;
    }
  }
  EXPECT_GT(num_over_body, 1000);
}

TEST(Clutter, HandRestsOrHoversOverTheBody) {
  const auto skin = trunk();
  const Clutter clutter(skin, kTableMm, SimulatedClutter::kHand, true, 4);
  int num_resting = 0;
  for (std::uint64_t id = 0; id < 20; ++id) {
    const auto hand = clutter.at(id, 0.0);
    float nearest_mm = 1e9F;
    for (std::size_t i = 0; i < hand.mesh.vertices.size(); i += 3) {
      const Vector3f& p = hand.mesh.vertices[i];
      if (p.z() < 0.0F || p.z() > 300.0F) continue;
      const float radius = std::hypot(p.x() / 180.0F, p.y() / 110.0F);
      nearest_mm = std::min(nearest_mm, (radius - 1.0F) * 110.0F);
    }
    EXPECT_LT(nearest_mm, 100.0F);
    EXPECT_GT(nearest_mm, -8.0F);  // The height map knows the skin in cells of 6 mm.
    num_resting += nearest_mm < 4.0F ? 1 : 0;
  }
  EXPECT_GT(num_resting, 4);
}

TEST(Clutter, IsRearrangedInEveryFrameOfViewsOnly) {
  const auto skin = trunk();
  const auto place = [](const Clutter& clutter, std::uint64_t id, double time_s) {
    return clutter.at(id, time_s).mesh.vertices.front();
  };
  const Clutter views(skin, kTableMm, SimulatedClutter::kHand, true, 4);
  EXPECT_GT((place(views, 0, 0.0) - place(views, 1, 0.0)).norm(), 5.0F);
  EXPECT_EQ(place(views, 1, 0.0), place(views, 1, 9.0));
  const Clutter path(skin, kTableMm, SimulatedClutter::kHand, false, 4);
  EXPECT_EQ(place(path, 0, 1.0), place(path, 7, 1.0));
  const float step_mm = (place(path, 0, 1.0) - place(path, 0, 1.0 + 1.0 / 30.0)).norm();
  EXPECT_GT(step_mm, 0.0F);
  EXPECT_LT(step_mm, 8.0F);  // The elbow's end, at the fastest.
  const Clutter towel(skin, kTableMm, SimulatedClutter::kTowel, false, 4);
  EXPECT_EQ(place(towel, 0, 1.0), place(towel, 7, 5.0));
}

TEST(Clutter, AllHoldsEachKind) {
  const auto skin = trunk();
  std::size_t num_vertices = 0;
  for (const auto kind :
       {SimulatedClutter::kHand, SimulatedClutter::kTowel, SimulatedClutter::kParts}) {
    num_vertices += Clutter(skin, kTableMm, kind, true, 4).at(3, 0.0).mesh.vertices.size();
  }
  const auto all = Clutter(skin, kTableMm, SimulatedClutter::kAll, true, 4).at(3, 0.0);
  EXPECT_EQ(all.mesh.vertices.size(), num_vertices);
  EXPECT_EQ(all.albedo.size(), num_vertices);
  EXPECT_EQ(all.gloss.size(), num_vertices);
  EXPECT_EQ(all.mesh.normals.size(), num_vertices);
}

TEST(ShadeMap, DarkensWhatIsBelowAndNotTheThingItself) {
  const auto ball = blended_surface({{{0, -60, 0}, {40, -60, 0}, 30.0F, 30.0F}}, 5.0F, 3.0F);
  const ShadeMap shade(ball);
  EXPECT_LT(shade.light({20.0F, 0.0F, 0.0F}), 0.8F);
  EXPECT_EQ(shade.light({20.0F, -90.0F, 0.0F}), 1.0F);
  EXPECT_EQ(shade.light({400.0F, 0.0F, 0.0F}), 1.0F);
  EXPECT_EQ(ShadeMap().light({0.0F, 0.0F, 0.0F}), 1.0F);
}

}  // namespace
}  // namespace mor::internal
