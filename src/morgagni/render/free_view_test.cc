// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Bodies whose shape is known, in a picture whose colours say where in it they are: (x, y, 200).
#include "morgagni/render/free_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

using ::testing::HasSubstr;

constexpr PinholeCamera kColorCamera{256, 240, 260.0, 262.0, 126.0, 121.0, {}};
constexpr double kBallMm = 100.0;
const Eigen::Isometry3d kColorFromCt = testing::at(0.0, 0.0, 500.0);
constexpr Rgba8 kBlack{0, 0, 0, 255};

Image<Rgb8> places_picture(int width = kColorCamera.width_px, int height = kColorCamera.height_px) {
  Image<Rgb8> picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      picture(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 200};
    }
  }
  return picture;
}

/// Looks at ct's origin from that side: yaw around the colour camera's y axis, then pitch.
Eigen::Isometry3d view_from(double yaw_rad, double pitch_rad, double distance_mm = 500.0) {
  Eigen::Isometry3d view_from_ct = testing::at(0.0, 0.0, distance_mm);
  view_from_ct.rotate(Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitX()));
  view_from_ct.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()));
  return view_from_ct;
}

class FreeViewTest : public ::testing::Test {
 protected:
  static std::unique_ptr<FreeViewRenderer> renderer_of(const RenderScene& scene) {
    auto renderer = FreeViewRenderer::create(scene);
    if (!renderer) throw std::runtime_error(renderer.error().message);
    return *std::move(renderer);
  }

  FreeView view_of(const Eigen::Isometry3d& view_from_ct) const {
    FreeView view;
    view.camera = {240, 240, 300.0, 300.0, 119.5, 119.5, {}};
    view.view_from_ct = view_from_ct;
    view.picture = {.color = color_.view(), .camera = kColorCamera, .color_from_ct = kColorFromCt};
    return view;
  }

  static FreePicture drawn(FreeViewRenderer& renderer, const FreeView& view) {
    auto picture = renderer.render(view);
    if (!picture) throw std::runtime_error(picture.error().message);
    return *picture;
  }

  const Image<Rgb8> color_ = places_picture();
};

/// The CT point seen at a pixel; none on the background.
std::optional<Eigen::Vector3d> ct_point(const FreePicture& drawn,
                                        const FreeView& view,
                                        int x,
                                        int y) {
  const float z = drawn.depth_mm(x, y);
  if (z <= 0.0F) return std::nullopt;
  return view.view_from_ct.inverse() * (z * view.camera.ray(Eigen::Vector2d(x, y)).homogeneous());
}

TEST_F(FreeViewTest, FromTheColorCamerasOwnPlaceTheSkinIsTheColorPicture) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 60)});
  FreeView view = view_of(kColorFromCt);
  view.camera = kColorCamera;
  const FreePicture shown = drawn(*renderer, view);
  int num_skin = 0;
  for (int y = 0; y < shown.picture.height(); ++y) {
    for (int x = 0; x < shown.picture.width(); ++x) {
      const auto point = ct_point(shown, view, x, y);
      const Rgba8& pixel = shown.picture(x, y);
      if (!point) {
        ASSERT_LE(pixel.r + pixel.g + pixel.b, 300) << "the background at " << x << ", " << y;
        continue;
      }
      const Eigen::Vector3d to_camera = Eigen::Vector3d(0, 0, -500.0) - *point;
      if (point->normalized().dot(to_camera.normalized()) < 0.25) continue;  // It fades there.
      ++num_skin;
      ASSERT_NEAR(pixel.r, x, 1) << x << ", " << y;
      ASSERT_NEAR(pixel.g, y, 1) << x << ", " << y;
      ASSERT_NEAR(pixel.b, 200, 1) << x << ", " << y;
    }
  }
  EXPECT_GT(num_skin, 7000);
}

/// No acne: of a ball, all that turns to both cameras has its colour, from straight to grazing.
TEST_F(FreeViewTest, AllThatTheColorCameraSeesOfABallIsInColors) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 60)});
  for (const double yaw : {0.0, 0.7, 1.3, std::numbers::pi / 2, 2.2}) {
    const FreeView view = view_of(view_from(yaw, 0.2));
    const FreePicture shown = drawn(*renderer, view);
    int num_seen = 0;
    for (int y = 0; y < shown.picture.height(); ++y) {
      for (int x = 0; x < shown.picture.width(); ++x) {
        const auto point = ct_point(shown, view, x, y);
        if (!point) continue;
        const Eigen::Vector3d normal = point->normalized();
        const Eigen::Vector3d eye = view.view_from_ct.inverse().translation();
        const double to_view = normal.dot((eye - *point).normalized());
        const double to_color = normal.dot((Eigen::Vector3d(0, 0, -500.0) - *point).normalized());
        if (to_view < 0.2) continue;  // The outline is softened.
        if (to_color > 0.2) {
          ++num_seen;
          ASSERT_GT(shown.picture(x, y).b, 190) << "yaw " << yaw << " at " << x << ", " << y;
        }
        // Anything else that turns to the viewer has been cut away.
        ASSERT_GT(to_color, 0.0) << "yaw " << yaw << " at " << x << ", " << y;
      }
    }
    EXPECT_GT(num_seen, yaw < 2.0 ? 2000 : 50) << yaw;
  }
}

TEST_F(FreeViewTest, FromBehindTheBallIsOpenAndBlackAndWhatIsInsideIsSeenInItsPlace) {
  RenderScene scene;
  scene.skin = testing::make_sphere({0, 0, 0}, kBallMm, 60);
  const Eigen::Vector3d inside(20.0, -10.0, 15.0);
  scene.structures = {{"stone", testing::make_sphere(inside, 12.0, 20), {1.0F, 0.0F, 0.0F}}};
  const auto renderer = renderer_of(scene);
  const FreeView view = view_of(view_from(std::numbers::pi, 0.0));
  const FreePicture shown = drawn(*renderer, view);
  const auto middle = view.camera.project(view.view_from_ct * inside).value();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int num_red = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 240; ++x) {
      const Rgba8& pixel = shown.picture(x, y);
      ASSERT_EQ(pixel.a, 255);
      if (pixel.r > 30) {
        ++num_red;
        sum += Eigen::Vector2d(x, y);
      } else if ((Eigen::Vector2d(x, y) - middle).norm() > 12.0) {
        ASSERT_EQ(pixel, kBlack) << x << ", " << y;
      }
    }
  }
  EXPECT_GT(num_red, 120);
  EXPECT_LT((sum / num_red - middle).norm(), 0.6);
}

TEST_F(FreeViewTest, TheSilhouetteIsTheBalls) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 90)});
  FreeView view = view_of(view_from(0.0, 0.0));
  view.shows_bare_skin = true;
  const FreePicture shown = drawn(*renderer, view);
  int num_body = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 240; ++x) num_body += shown.depth_mm(x, y) > 0.0F ? 1 : 0;
  }
  const double radius_px = 300.0 * std::tan(std::asin(kBallMm / 500.0));
  EXPECT_NEAR(std::sqrt(num_body / std::numbers::pi), radius_px, 0.5);
}

TEST_F(FreeViewTest, SkinWithoutColorsIsHatchedWhereItIsAskedForAndCutAwayElse) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 60)});
  FreeView view = view_of(view_from(0.0, 0.0));
  view.picture.reset();
  EXPECT_EQ(drawn(*renderer, view).picture(120, 120), kBlack);
  view.shows_bare_skin = true;
  const FreePicture shown = drawn(*renderer, view);
  int least = 255;
  int most = 0;
  for (int x = 110; x < 130; ++x) {
    least = std::min<int>(least, shown.picture(x, 120).b);
    most = std::max<int>(most, shown.picture(x, 120).b);
  }
  EXPECT_GT(least, 60);
  EXPECT_GT(most - least, 20) << "no hatching";
  EXPECT_LT(most, 160) << "could be taken for the picture";
}

TEST_F(FreeViewTest, WhatIsInFrontOfTheSkinIsNotPaintedOnIt) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 60)});
  // The depth camera sees the ball, and a board 60 mm before it over the picture's left half.
  Image<std::uint16_t> depth(kColorCamera.width_px, kColorCamera.height_px, 0);
  Image<Rgb8> color = places_picture();
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const Eigen::Vector3d ray =
          kColorCamera.ray(Eigen::Vector2d(x, y)).homogeneous().normalized();
      const double along = ray.z() * 500.0;
      const double beside_sq = 500.0 * 500.0 - along * along;
      const bool is_board = x < 126;
      color(x, y) = is_board ? Rgb8{30, 30, 250} : Rgb8{220, 170, 150};
      if (is_board) {
        depth(x, y) = 340;
      } else if (beside_sq < kBallMm * kBallMm) {
        const double t = along - std::sqrt(kBallMm * kBallMm - beside_sq);
        depth(x, y) = static_cast<std::uint16_t>(std::lround(t * ray.z()));
      }
    }
  }
  FreeView view = view_of(kColorFromCt);
  view.camera = kColorCamera;
  view.picture->color = color.view();
  EXPECT_GT(drawn(*renderer, view).picture(100, 121).b, 200) << "nobody said what is in front";
  view.picture->measured = {depth.view(), kColorCamera, Eigen::Isometry3d::Identity()};
  const FreePicture shown = drawn(*renderer, view);
  for (const int x : {90, 105, 120}) EXPECT_EQ(shown.picture(x, 121), kBlack) << x;
  for (const int x : {132, 145, 160}) EXPECT_NEAR(shown.picture(x, 121).r, 220, 2) << x;
}

TEST_F(FreeViewTest, TheHoleOfThePictureIsCutIntoTheSkin) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 60)});
  FreeView view = view_of(kColorFromCt);
  view.camera = kColorCamera;
  view.picture->hole = {.center = {0.5F, 0.5F}, .radius = 0.1F, .rim = 0.01F};
  const FreePicture shown = drawn(*renderer, view);
  EXPECT_EQ(shown.picture(127, 119), kBlack);
  EXPECT_EQ(shown.picture(127 + 20, 119), kBlack);
  EXPECT_NEAR(shown.picture(127 + 28, 119).r, 155, 1);
}

/// A square 100 mm wide before the camera, in an atlas of two colours whose right part nobody saw.
AtlasPicture atlas_of_a_square() {
  auto surface = std::make_shared<AtlasSurface>();
  surface->mesh.vertices = {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}};
  surface->mesh.normals.assign(4, {0, 0, -1});
  surface->mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  surface->corners_px = {{{{10, 10}, {90, 90}, {90, 10}}}, {{{10, 10}, {10, 90}, {90, 90}}}};
  surface->width_px = 100;
  surface->height_px = 100;
  auto colors = std::make_shared<Image<Rgba8>>(100, 100);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const auto alpha = static_cast<std::uint8_t>(x < 70 ? 255 : 0);
      (*colors)(x, y) = {
          static_cast<std::uint8_t>(2 * x), static_cast<std::uint8_t>(2 * y), 9, alpha};
    }
  }
  return {surface, colors};
}

TEST_F(FreeViewTest, AnAtlasIsLaidOnItsSurfaceAndItsUnseenPartIsLeftOut) {
  const auto renderer = renderer_of({});
  FreeView view = view_of(testing::at(0, 0, 500));
  view.picture.reset();
  view.atlas = atlas_of_a_square();
  // 100 mm are 60 px from pixel 89.5 on, and 80 px of the atlas from pixel 10 on.
  const FreePicture shown = drawn(*renderer, view);
  EXPECT_NEAR(shown.picture(100, 110).r, 2 * (10 + (100 - 89.5) * 80 / 60), 2);
  EXPECT_NEAR(shown.picture(100, 110).g, 2 * (10 + (110 - 89.5) * 80 / 60), 2);
  EXPECT_EQ(shown.picture(140, 110), kBlack);
  EXPECT_EQ(shown.picture(60, 110), kBlack);

  auto redder = std::make_shared<Image<Rgba8>>(100, 100, Rgba8{250, 0, 0, 255});
  view.atlas->colors = redder;
  EXPECT_NEAR(drawn(*renderer, view).picture(140, 110).r, 250, 1) << "the new picture is not shown";
}

TEST_F(FreeViewTest, DrawsPicturesOfOddSizesAndBodiesThatTheColorCameraDoesNotSee) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 20)});
  FreeView view = view_of(view_from(0.4, 0.1));
  view.camera = {641, 479, 530.0, 528.0, 318.0, 242.0, {}};
  EXPECT_EQ(drawn(*renderer, view).picture.width(), 641);
  view.picture->color_from_ct = testing::at(0, 0, -500);  // Behind it.
  EXPECT_EQ(drawn(*renderer, view).picture(320, 240), kBlack);
  view.view_from_ct = testing::at(0, 0, -500);
  EXPECT_EQ(drawn(*renderer, view).picture(320, 240), kBlack);
  view.view_from_ct = testing::at(0, 0, 0);  // In the middle of the body.
  EXPECT_TRUE(renderer->render(view));
}

TEST_F(FreeViewTest, RefusesWhatIsNoViewAndSaysWhy) {
  const auto renderer =
      renderer_of({.structures = {}, .skin = testing::make_sphere({0, 0, 0}, kBallMm, 20)});
  const auto why = [&](const FreeView& view) {
    const auto result = renderer->render(view);
    return result ? std::string("drawn") : result.error().message;
  };
  FreeView view = view_of(view_from(0.0, 0.0));
  view.picture->camera.width_px = 640;
  EXPECT_THAT(why(view), HasSubstr("256 x 240 px, its camera 640 x 240 px"));
  view = view_of(view_from(0.0, 0.0));
  view.view_from_ct.translation().x() = std::nan("");
  EXPECT_THAT(why(view), HasSubstr("finite"));
  view = view_of(view_from(0.0, 0.0));
  view.camera.focal_x_px = 0.0;
  EXPECT_THAT(why(view), HasSubstr("positive focal lengths"));
  view = view_of(view_from(0.0, 0.0));
  view.structure_opacity["bone"] = 2.0F;
  EXPECT_THAT(why(view), HasSubstr("opacity of bone must be in [0, 1], got 2"));
  view.structure_opacity.clear();
  view.atlas = atlas_of_a_square();
  view.atlas->colors = std::make_shared<Image<Rgba8>>(50, 100);
  EXPECT_THAT(why(view), HasSubstr("the atlas is 100 x 100 px, its picture 50 x 100 px"));
  view.atlas->colors.reset();
  EXPECT_THAT(why(view), HasSubstr("needs a surface and a picture"));
}

}  // namespace
}  // namespace mor
