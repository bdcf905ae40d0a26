// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/skin_texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using ::testing::HasSubstr;

SkinAtlas one_triangle() {
  SkinAtlas atlas;
  atlas.mesh.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
  atlas.mesh.triangles = {{0, 1, 2}};
  atlas.corners_px = {{Eigen::Vector2f(0, 0), Eigen::Vector2f(9, 0), Eigen::Vector2f(0, 9)}};
  atlas.width_px = 10;
  atlas.height_px = 10;
  return atlas;
}

TEST(SkinAtlas, AcceptsTrianglesInsideThePicture) {
  EXPECT_TRUE(one_triangle().check().has_value());
}

TEST(SkinAtlas, NamesTheTriangleOutsideOfThePicture) {
  auto atlas = one_triangle();
  atlas.corners_px[0][1].x() = 10.0F;
  const auto checked = atlas.check();
  ASSERT_FALSE(checked.has_value());
  EXPECT_THAT(checked.error().message, HasSubstr("triangle 0 lies at (10, 0) px"));
}

TEST(SkinAtlas, AsksForCornersOfEachTriangle) {
  auto atlas = one_triangle();
  atlas.corners_px.clear();
  ASSERT_FALSE(atlas.check().has_value());
}

TEST(SkinTexture, KnowsWhatWasNeverSeen) {
  SkinTexture texture;
  texture.sources = Image<TexelSource>(2, 1);
  texture.sources(1, 0).frame = 0;
  EXPECT_FALSE(texture.is_seen(0, 0));
  EXPECT_TRUE(texture.is_seen(1, 0));
}

}  // namespace
}  // namespace mor
