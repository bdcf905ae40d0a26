// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/printable.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/documentation/testing/tube_body.h"

namespace mor {
namespace {

using ::testing::HasSubstr;
using testing_body::ball;
using testing_body::tube_skin;

/// Of the tube with flat lids, by Simpson over z: area = pi a b bulge^2.
double tube_volume_mm3() {
  constexpr int kSteps = 2000;
  double sum = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double z = 40.0 + 200.0 * i / kSteps;
    const double bulge = 1.0 + 0.15 * std::sin(z / 40.0);
    sum += (i == 0 || i == kSteps ? 0.5 : 1.0) * std::numbers::pi * 85.0 * 60.0 * bulge * bulge;
  }
  return sum * 200.0 / kSteps;
}

TEST(SolidCheck, FindsWhatIsOpenTurnedAndPinched) {
  auto mesh = ball("ball", {}, {0, 0, 0}).mesh;
  EXPECT_TRUE(check_solid(mesh).is_solid());
  EXPECT_NEAR(check_solid(mesh).volume_mm3, 4.0 / 3.0 * std::numbers::pi * 25 * 25 * 25, 2000.0);
  auto open = mesh;
  open.triangles.pop_back();
  EXPECT_EQ(check_solid(open).num_open_edges, 3U);
  auto turned = mesh;
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  EXPECT_GT(check_solid(turned).num_turned_edges, 0U);
  auto inside_out = mesh;
  for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_FALSE(check_solid(inside_out).is_solid());
  auto pinched = mesh;
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& v : mesh.vertices) pinched.vertices.emplace_back(v + Eigen::Vector3f(50, 0, 0));
  for (auto triangle : mesh.triangles) {
    for (auto& corner : triangle) corner = corner == 1 ? 0 : corner + count;  // -x meets +x.
    pinched.triangles.push_back(triangle);
  }
  EXPECT_EQ(check_solid(pinched).num_pinched_vertices, 1U);
}

TEST(Printable, ClosesTheEndsOfATubeByLids) {
  const auto skin = tube_skin();
  EXPECT_EQ(check_solid(skin).num_open_edges, 2U * testing_body::kAround);
  const auto solid = make_printable(skin, {});
  ASSERT_TRUE(solid.has_value()) << solid.error().message;
  EXPECT_EQ(solid->num_open_ends, 2U);
  const auto check = check_solid(solid->mesh);
  EXPECT_TRUE(check.is_solid());
  EXPECT_NEAR(check.volume_mm3, tube_volume_mm3(), 0.01 * tube_volume_mm3());
  // The skin itself is as it was.
  for (std::size_t i = 0; i < skin.triangles.size(); ++i)
    ASSERT_EQ(solid->mesh.triangles[i], skin.triangles[i]);
}

TEST(Printable, MakesAWallOfTheThicknessAskedFor) {
  const auto skin = tube_skin();
  const auto solid = make_printable(skin, {PrintForm::kShell, 4.0});
  ASSERT_TRUE(solid.has_value()) << solid.error().message;
  const auto check = check_solid(solid->mesh);
  EXPECT_TRUE(check.is_solid());
  EXPECT_NEAR(check.volume_mm3, 4.0 * surface_area_mm2(skin), 0.08 * 4.0 * surface_area_mm2(skin));
  EXPECT_NEAR(solid->thinnest_mm, 4.0, 0.05);
  EXPECT_LT(solid->thin_share, 0.01);
}

TEST(Printable, KeepsTheWallInsideOfAThinBody) {
  // A plate 6 mm thick has no room for walls of 5 mm on both sides.
  auto plate = ball("plate", {}, {0, 0, 0}).mesh;
  for (auto& v : plate.vertices) v.z() *= 3.0F / 25.0F;
  plate.normals = vertex_normals(plate);
  const auto solid = make_printable(plate, {PrintForm::kShell, 5.0});
  ASSERT_TRUE(solid.has_value()) << solid.error().message;
  EXPECT_LT(solid->thinnest_mm, 3.0);
  EXPECT_GT(solid->thin_share, 0.9);
  EXPECT_LT(check_solid(solid->mesh).volume_mm3, check_solid(plate).volume_mm3);
}

TEST(Printable, MeasuresHowThickTheBodyIs) {
  const auto mesh = ball("ball", {}, {0, 0, 0}).mesh;
  for (const float thickness : local_thickness_mm(mesh, 100.0)) EXPECT_NEAR(thickness, 50.0F, 1.0F);
}

TEST(Printable, SaysWhyASkinCannotBeClosed) {
  auto mesh = tube_skin();
  mesh.triangles.push_back(mesh.triangles.front());
  const auto solid = make_printable(mesh, {});
  ASSERT_FALSE(solid.has_value());
  EXPECT_THAT(solid.error().message, HasSubstr("cannot be made printable"));
  EXPECT_THAT(make_printable(tube_skin(), {PrintForm::kShell, 0.1}).error().message,
              HasSubstr("wall_mm must be 0.5 to 20, got 0.1"));
}

}  // namespace
}  // namespace mor
