// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/skin_view.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/geometry/depth_raster.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr double kPi = std::numbers::pi;

/// The corner is background.
bool is_lit(const SkinView& view, int x, int y) {
  return view.picture(x, y) != view.picture(0, 0);
}

/// Whether something nearer or farther than `depth_mm` is seen within a pixel of this one.
bool is_hidden_or_at_an_outline(const SkinView& view,
                                const Eigen::Vector2d& pixel,
                                double depth_mm) {
  for (const int dy : {0, 1}) {
    for (const int dx : {0, 1}) {
      const int x = static_cast<int>(std::floor(pixel.x())) + dx;
      const int y = static_cast<int>(std::floor(pixel.y())) + dy;
      if (std::abs(view.depth_mm(x, y) - depth_mm) > 2.0) return true;
    }
  }
  return false;
}

TEST(SkinView, PicksBackTheVerticesItShows) {
  TriangleMesh skin = testing::make_sphere({20.0, -30.0, 400.0}, 100.0, 60);
  testing::append(skin, testing::make_torus({20.0, -180.0, 400.0}, 30.0, 12.0, 80, 30));
  const SkinView view = draw_skin_view(skin, {.yaw_rad = 0.4, .pitch_rad = 0.2});
  int num_picked = 0;
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const Eigen::Vector3d vertex = skin.vertices[i].cast<double>();
    const Eigen::Vector3d seen = view.view_from_ct * vertex;
    const double facing =
        -(view.view_from_ct.linear() * skin.normals[i].cast<double>()).dot(seen.normalized());
    if (facing < 0.5) continue;  // Beyond 60 degrees a pixel is more than twice as deep as wide.
    const Eigen::Vector2d pixel = *view.camera.project(seen);
    if (is_hidden_or_at_an_outline(view, pixel, seen.z())) continue;
    const auto picked = view.ct_point(pixel);
    ASSERT_TRUE(picked);
    EXPECT_LT((*picked - vertex).norm(), 0.2);
    ++num_picked;
  }
  EXPECT_GT(num_picked, 900);
}

TEST(SkinView, PicksTheNearerSurface) {
  TriangleMesh skin = testing::make_sphere({0.0, 0.0, 0.0}, 100.0, 40);
  testing::append(skin, testing::make_sphere({0.0, -150.0, 0.0}, 20.0, 40));
  const SkinView view = draw_skin_view(skin, {});
  const auto pixel = view.camera.project(view.view_from_ct * Eigen::Vector3d(0.0, -100.0, 0.0));
  const auto picked = view.ct_point(*pixel);
  ASSERT_TRUE(picked);
  EXPECT_LT((*picked - Eigen::Vector3d(0.0, -170.0, 0.0)).norm(), 0.2);
}

/// Where on the picture a direction of the body points, from its middle.
Eigen::Vector2d shown_direction(const SkinView& view, const Eigen::Vector3d& direction) {
  return *view.camera.project(view.view_from_ct * direction) -
         *view.camera.project(view.view_from_ct * Eigen::Vector3d::Zero());
}

TEST(SkinView, ShowsTheBodyAsAVisitorAtItsFrontSeesIt) {
  const SkinView view = draw_skin_view(testing::make_sphere({0, 0, 0}, 100.0, 20), {});
  EXPECT_LT(shown_direction(view, {0.0, 0.0, 10.0}).y(), -1.0) << "the head is up";
  EXPECT_GT(shown_direction(view, {10.0, 0.0, 0.0}).x(), 1.0) << "its left is at our right";
  EXPECT_NEAR(view.ct_point({319.5, 239.5})->y(), -100.0, 0.5) << "anterior is near";
}

TEST(SkinView, YawAQuarterTurnShowsTheBodysLeftSide) {
  const SkinView view =
      draw_skin_view(testing::make_sphere({0, 0, 0}, 100.0, 20), {.yaw_rad = 0.5 * kPi});
  EXPECT_NEAR(view.ct_point({319.5, 239.5})->x(), 100.0, 0.5);
  EXPECT_LT(shown_direction(view, {0.0, 0.0, 10.0}).y(), -1.0);
}

TEST(SkinView, PitchLooksDownFromTheHead) {
  const SkinView view =
      draw_skin_view(testing::make_sphere({0, 0, 0}, 100.0, 20), {.pitch_rad = 0.5 * kPi});
  EXPECT_NEAR(view.ct_point({319.5, 239.5})->z(), 100.0, 0.5);
}

TEST(SkinView, TheWholeSkinFitsAtZoomOne) {
  for (const auto& [width, height] : {std::pair{640, 480}, {301, 799}}) {
    const SkinView view = draw_skin_view(testing::make_torus({0, 0, 0}, 100.0, 20.0, 40, 12),
                                         {.width_px = width, .height_px = height});
    int num_lit = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool is_border = x == 0 || y == 0 || x == width - 1 || y == height - 1;
        if (is_border) {
          EXPECT_FALSE(is_lit(view, x, y));
        }
        num_lit += is_lit(view, x, y) ? 1 : 0;
      }
    }
    EXPECT_GT(num_lit, width * height / 40);
  }
}

TEST(SkinView, PictureAndDepthShowTheSamePixels) {
  const SkinView view = draw_skin_view(testing::make_sphere({0, 0, 0}, 100.0, 40), {.zoom = 0.7});
  int num_different = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      num_different += is_lit(view, x, y) != (view.depth_mm(x, y) > 0.0F) ? 1 : 0;
    }
  }
  EXPECT_LT(num_different, 1500) << "more than the outline differs";
}

TEST(SkinView, GivesNoPointOnTheBackgroundOrOutside) {
  const SkinView view = draw_skin_view(testing::make_sphere({0, 0, 0}, 100.0, 20), {});
  EXPECT_FALSE(view.ct_point({2.0, 2.0}));
  EXPECT_FALSE(view.ct_point({-3.0, 240.0}));
  EXPECT_FALSE(view.ct_point({320.0, 480.0}));
  EXPECT_FALSE(view.ct_point({std::numeric_limits<double>::quiet_NaN(), 10.0}));
}

TEST(SkinView, DrawsNothingOfAnEmptySkin) {
  const SkinView view = draw_skin_view({}, {.zoom = std::nan("")});
  EXPECT_EQ(view.picture.width(), 640);
  EXPECT_FALSE(is_lit(view, 320, 240));
  EXPECT_FALSE(view.ct_point({320.0, 240.0}));
}

}  // namespace
}  // namespace mor
