// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/overlay_renderer.h"

#include <cstdlib>
#include <iostream>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{640, 480, 525.0, 525.0, 319.5, 239.5, {}};
constexpr PinholeCamera kOffCenter{641, 479, 610.0, 590.0, 300.25, 251.5, {}};
constexpr PinholeCamera kBarrel{
    641, 479, 610.0, 590.0, 300.25, 251.5, {-0.28, 0.11, 0.002, -0.003, -0.02}};
constexpr PinholeCamera kFullHd{
    1920, 1080, 1400.0, 1410.0, 971.0, 523.0, {0.12, -0.2, -0.001, 0.002, 0.05}};

Image<Rgb8> gray(const PinholeCamera& camera) {
  return {camera.width_px, camera.height_px, Rgb8{100, 100, 100}};
}

/// A picture in which every pixel differs from its neighbours.
Image<Rgb8> pattern(const PinholeCamera& camera) {
  Image<Rgb8> picture(camera.width_px, camera.height_px);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      picture(x, y) = {static_cast<std::uint8_t>(x * 7 + y),
                       static_cast<std::uint8_t>(y * 5 + 3),
                       static_cast<std::uint8_t>(x ^ y)};
    }
  }
  return picture;
}

Image<Rgba8> opaque(const Image<Rgb8>& color) {
  Image<Rgba8> picture(color.width(), color.height());
  for (std::size_t i = 0; i < color.size(); ++i) {
    const Rgb8& pixel = color.data()[i];
    picture.data()[i] = {pixel.r, pixel.g, pixel.b, 255};
  }
  return picture;
}

using testing::at;
using testing::rendered;

std::unique_ptr<OverlayRenderer> make_renderer(const TriangleMesh& bones,
                                               const Eigen::Vector3f& color = {1.0F, 0.0F, 0.0F},
                                               const TriangleMesh& skin = {}) {
  return testing::make_renderer({{{"bones", bones, color}}, skin});
}

OverlayView everywhere(const PinholeCamera& camera, const Eigen::Isometry3d& pose) {
  return {.color_camera = camera, .color_from_ct = pose, .opacity = 1.0F, .hole = {.radius = 2.0F}};
}

/// Red bones on a grey picture: green is what is left of the picture, 50 of 100 in an open hole.
/// More than half of the pixel is bone where less than half of that is left.
bool is_bone(const Rgba8& pixel) {
  return pixel.g < 25;
}

/// Middle of the bone's pixels.
Eigen::Vector2d bone_center(const Image<Rgba8>& picture) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      if (!is_bone(picture(x, y))) continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
    }
  }
  return sum / std::max(count, 1);
}

/// Whether the pinhole's ray meets a ball around `center`.
bool ray_hits(const PinholeCamera& camera,
              const Eigen::Vector2d& pixel,
              const Eigen::Vector3d& center,
              double radius_mm) {
  const Eigen::Vector3d ray = camera.ray(pixel).homogeneous().normalized();
  return (center - ray * ray.dot(center)).norm() < radius_mm && center.z() > 0.0;
}

class OverlayRendererCamera : public ::testing::TestWithParam<PinholeCamera> {};

TEST_P(OverlayRendererCamera, DrawsSmallBallsWhereTheCameraProjectsThem) {
  const PinholeCamera camera = GetParam();
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 4.0, 24));
  const Image<Rgb8> color = gray(camera);
  for (const double share_y : {0.1, 0.45, 0.9}) {
    for (const double share_x : {0.08, 0.5, 0.93}) {
      const Eigen::Vector2d pixel(share_x * camera.width_px, share_y * camera.height_px);
      const Eigen::Vector3d center = 600.0 * camera.ray(pixel).homogeneous();
      const auto picture =
          rendered(*renderer, color, everywhere(camera, at(center.x(), center.y(), center.z())));
      EXPECT_LT((bone_center(picture) - *camera.project(center)).norm(), 0.5)
          << "at " << pixel.transpose();
    }
  }
}

TEST_P(OverlayRendererCamera, CoversABallsOutlineToHalfAPixel) {
  const PinholeCamera camera = GetParam();
  constexpr double kRadiusMm = 90.0;
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), kRadiusMm, 70));
  const Eigen::Vector3d center(60.0, -35.0, 500.0);
  const auto picture =
      rendered(*renderer, gray(camera), everywhere(camera, at(center.x(), center.y(), center.z())));
  // Half a pixel in mm at the ball; the facets of the sphere stand back by up to 0.1 mm.
  const double half_px_mm = 0.5 * center.norm() / std::min(camera.focal_x_px, camera.focal_y_px);
  int num_wrong = 0;
  int num_bone = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Eigen::Vector2d pixel(x, y);
      const bool is_surely_in = ray_hits(camera, pixel, center, kRadiusMm - 0.1 - half_px_mm);
      const bool is_surely_out = !ray_hits(camera, pixel, center, kRadiusMm + half_px_mm);
      num_bone += is_bone(picture(x, y)) ? 1 : 0;
      if (is_bone(picture(x, y)) ? is_surely_out : is_surely_in) ++num_wrong;
    }
  }
  EXPECT_GT(num_bone, 10000);
  EXPECT_EQ(num_wrong, 0);
}

/// Whether the pinhole's ray meets a cube around the origin of ct.
bool ray_hits_cube(const PinholeCamera& camera,
                   const Eigen::Vector2d& pixel,
                   const Eigen::Isometry3d& color_from_ct,
                   double half_mm) {
  const Eigen::Isometry3d ct_from_color = color_from_ct.inverse();
  const Eigen::Vector3d direction = camera.ray(pixel).homogeneous();
  const Eigen::Array3d ray = (ct_from_color.linear() * direction).array();
  const Eigen::Array3d eye = ct_from_color.translation().array();
  const Eigen::Array3d a = (-half_mm - eye) / ray;
  const Eigen::Array3d b = (half_mm - eye) / ray;
  return a.min(b).maxCoeff() < a.max(b).minCoeff();
}

TEST_P(OverlayRendererCamera, CoversACubesOutlineToHalfAPixel) {
  const PinholeCamera camera = GetParam();
  constexpr double kHalfMm = 70.0;
  const auto renderer = make_renderer(testing::make_cube(kHalfMm, 24));
  Eigen::Isometry3d pose = at(-50.0, 30.0, 520.0);
  pose.linear() = (Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  const auto picture = rendered(*renderer, gray(camera), everywhere(camera, pose));
  // Where the half side grows by a mm, an edge moves by up to the square root of two.
  const double half_px_mm =
      0.5 / std::numbers::sqrt2 * 520.0 / std::min(camera.focal_x_px, camera.focal_y_px);
  int num_wrong = 0;
  int num_bone = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Eigen::Vector2d pixel(x, y);
      const bool is_shown = is_bone(picture(x, y));
      num_bone += is_shown ? 1 : 0;
      if (is_shown ? !ray_hits_cube(camera, pixel, pose, kHalfMm + half_px_mm)
                   : ray_hits_cube(camera, pixel, pose, kHalfMm - half_px_mm)) {
        ++num_wrong;
      }
    }
  }
  EXPECT_GT(num_bone, 10000);
  EXPECT_EQ(num_wrong, 0);
}

INSTANTIATE_TEST_SUITE_P(Cameras,
                         OverlayRendererCamera,
                         ::testing::Values(kCamera, kOffCenter, kBarrel, kFullHd));

TEST(OverlayRenderer, LeavesThePictureAloneWithoutAPose) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 10));
  const Image<Rgb8> color = pattern(kCamera);
  EXPECT_EQ(rendered(*renderer, color, {.color_camera = kCamera}), opaque(color));
}

TEST(OverlayRenderer, LeavesThePictureAloneWithAHoleOfRadiusZero) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 10));
  const Image<Rgb8> color = pattern(kCamera);
  OverlayView view = everywhere(kCamera, at(0.0, 0.0, 500.0));
  view.hole.radius = 0.0F;
  EXPECT_EQ(rendered(*renderer, color, view), opaque(color));
}

TEST(OverlayRenderer, LeavesThePictureAloneAtOpacityZero) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 10));
  const Image<Rgb8> color = pattern(kCamera);
  OverlayView view{.color_camera = kCamera, .color_from_ct = at(0.0, 0.0, 500.0), .opacity = 0.0F};
  EXPECT_EQ(rendered(*renderer, color, view), opaque(color));
}

TEST(OverlayRenderer, ChangesNothingOutsideOfTheHole) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 200.0, 30));
  const Image<Rgb8> color = pattern(kCamera);
  OverlayView view{.color_camera = kCamera, .color_from_ct = at(0.0, 0.0, 500.0)};
  view.hole = {.center = {0.25F, 0.6F}, .radius = 0.2F, .rim = 0.04F};
  const auto picture = rendered(*renderer, color, view);
  const Eigen::Vector2d center(0.25 * 640 - 0.5, 0.6 * 480 - 0.5);
  int num_changed_inside = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const double distance_px = (Eigen::Vector2d(x, y) - center).norm();
      const Rgb8& before = color(x, y);
      const bool is_same = picture(x, y) == Rgba8{before.r, before.g, before.b, 255};
      if (distance_px > (0.2 + 0.02) * 480 + 2.0) {
        ASSERT_TRUE(is_same) << x << ", " << y;
      } else if (!is_same) {
        ++num_changed_inside;
      }
    }
  }
  EXPECT_GT(num_changed_inside, 0.9 * std::numbers::pi * 0.2 * 0.2 * 480 * 480);
}

TEST(OverlayRenderer, AHoleOutsideOfThePictureChangesNothing) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 200.0, 30));
  const Image<Rgb8> color = pattern(kCamera);
  OverlayView view{.color_camera = kCamera, .color_from_ct = at(0.0, 0.0, 500.0)};
  view.hole = {.center = {-3.0F, 9.0F}, .radius = 0.3F};
  EXPECT_EQ(rendered(*renderer, color, view), opaque(color));
}

TEST(OverlayRenderer, ShowsTheNearerOfTwoStructures) {
  const Eigen::Vector3d near(0.0, 0.0, -60.0);
  const Eigen::Vector3d far(0.0, 0.0, 60.0);
  const RenderedStructure red{"red", testing::make_sphere(near, 20.0, 20), {1.0F, 0.0F, 0.0F}};
  const RenderedStructure green{"green", testing::make_sphere(far, 50.0, 20), {0.0F, 1.0F, 0.0F}};
  for (const auto& structures : {std::vector{red, green}, std::vector{green, red}}) {
    const auto renderer = OverlayRenderer::create({structures, {}});
    ASSERT_TRUE(renderer) << renderer.error().message;
    const auto picture =
        rendered(**renderer, gray(kCamera), everywhere(kCamera, at(0.0, 0.0, 600.0)));
    EXPECT_GT(picture(320, 240).r, 100);
    EXPECT_EQ(picture(320, 240).g, 0);
    EXPECT_GT(picture(320 + 34, 240).g, 50);
    EXPECT_EQ(picture(320 + 34, 240).r, 0);
  }
}

TEST(OverlayRenderer, DrawsNoStructureThatIsHidden) {
  const RenderedStructure red{
      "red", testing::make_sphere({0.0, 0.0, -60.0}, 20.0, 20), {1.0F, 0.0F, 0.0F}};
  const RenderedStructure green{
      "green", testing::make_sphere({0.0, 0.0, 60.0}, 50.0, 20), {0.0F, 1.0F, 0.0F}};
  const auto renderer = OverlayRenderer::create({{red, green}, {}});
  ASSERT_TRUE(renderer) << renderer.error().message;
  OverlayView view = everywhere(kCamera, at(0.0, 0.0, 600.0));
  view.structure_opacity = {{"red", 0.0F}};
  EXPECT_GT(rendered(**renderer, gray(kCamera), view)(320, 240).g, 100);
  view.structure_opacity = {{"red", 0.0F}, {"green", 0.0F}};
  EXPECT_EQ(rendered(**renderer, gray(kCamera), view), opaque(gray(kCamera)));
}

TEST(OverlayRenderer, OpacityIsTheShareOfTheStructures) {
  const auto renderer =
      make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 30), {0.0F, 0.0F, 1.0F});
  OverlayView view = everywhere(kCamera, at(0.0, 0.0, 500.0));
  const int full = rendered(*renderer, gray(kCamera), view)(320, 240).b;
  view.opacity = 0.5F;
  const Rgba8 half = rendered(*renderer, gray(kCamera), view)(320, 240);
  // Red comes from the picture alone, so it says how much of the picture is left.
  EXPECT_NEAR(half.b, half.r + full / 2.0, 2.0);
  EXPECT_GT(half.r, 20);
  EXPECT_LT(half.r, 60);
}

TEST(OverlayRenderer, TheSameSceneGivesTheSamePixels) {
  const auto renderer = make_renderer(testing::make_bones(30000));
  const OverlayView view{.color_camera = kBarrel, .color_from_ct = at(10.0, -5.0, 600.0)};
  const Image<Rgb8> color = pattern(kBarrel);
  const auto first = rendered(*renderer, color, view);
  rendered(*renderer, pattern(kFullHd), everywhere(kFullHd, at(0.0, 0.0, 300.0)));
  EXPECT_EQ(rendered(*renderer, color, view), first);
}

TEST(OverlayRenderer, ShowsNothingOfABodyBehindTheCamera) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 10));
  const Image<Rgb8> color = pattern(kBarrel);
  EXPECT_EQ(rendered(*renderer, color, everywhere(kBarrel, at(0.0, 0.0, -400.0))), opaque(color));
}

TEST(OverlayRenderer, FillsThePictureFromInsideOfAnOpenSurface) {
  // Half a shell around the camera: its inside is seen, parts of it lie behind the camera.
  TriangleMesh shell = testing::make_sphere(Eigen::Vector3d::Zero(), 300.0, 40);
  shell.triangles.resize(shell.triangles.size() - 10);
  const auto renderer = make_renderer(shell);
  const auto picture = rendered(*renderer, gray(kOffCenter), everywhere(kOffCenter, at(0, 0, 0)));
  for (const auto& [x, y] : {std::pair{5, 5}, {320, 240}, {630, 470}, {5, 470}}) {
    EXPECT_TRUE(is_bone(picture(x, y))) << x << ", " << y;
  }
}

TEST(OverlayRenderer, TheGhostIsDrawnOverEverythingWhereItsPoseSays) {
  const auto renderer = make_renderer(
      {}, {1.0F, 0.0F, 0.0F}, testing::make_sphere(Eigen::Vector3d::Zero(), 60.0, 60));
  const Image<Rgb8> color = gray(kOffCenter);
  OverlayView view{.color_camera = kOffCenter};
  const Eigen::Vector3d center(-80.0, 40.0, 600.0);
  view.color_from_ghost = at(center.x(), center.y(), center.z());
  const auto picture = rendered(*renderer, color, view);
  const double px_mm = center.norm() / kOffCenter.focal_y_px;  // Its outline is softened by one.
  const Rgba8 untouched{100, 100, 100, 255};
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Eigen::Vector2d pixel(x, y);
      if (ray_hits(kOffCenter, pixel, center, 59.9 - 0.5 * px_mm)) {
        ASSERT_NE(picture(x, y), untouched) << x << ", " << y;
      } else if (!ray_hits(kOffCenter, pixel, center, 60.0 + 1.5 * px_mm)) {
        ASSERT_EQ(picture(x, y), untouched) << x << ", " << y;
      }
    }
  }
}

TEST(OverlayRenderer, TwoRenderersOnOneThreadDoNotDisturbEachOther) {
  const auto left = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 20));
  const OverlayView view = everywhere(kCamera, at(0.0, 0.0, 500.0));
  const auto before = rendered(*left, gray(kCamera), view);
  {
    const auto right = make_renderer(testing::make_bones(5000));
    rendered(*right, gray(kFullHd), everywhere(kFullHd, at(0.0, 0.0, 500.0)));
  }
  EXPECT_EQ(rendered(*left, gray(kCamera), view), before);
}

TEST(OverlayRenderer, RefusesBadViewsInOneSentence) {
  const auto renderer = make_renderer(testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 10));
  const Image<Rgb8> color = gray(kCamera);
  const auto message = [&](const OverlayView& view) {
    const auto result = renderer->render(color.view(), view);
    return result ? std::string("accepted") : result.error().message;
  };
  OverlayView view{.color_camera = kOffCenter};
  EXPECT_EQ(message(view), "the colour picture is 640 x 480 px, its camera 641 x 479 px");
  view = {.color_camera = kCamera, .opacity = 1.5F};
  EXPECT_EQ(message(view), "opacity must be in [0, 1], got 1.5");
  view = {.color_camera = kCamera, .hole = {.radius = std::numeric_limits<float>::quiet_NaN()}};
  EXPECT_THAT(message(view), ::testing::HasSubstr("must be finite"));
  view = {.color_camera = kCamera, .color_from_ct = at(0.0, std::nan(""), 0.0)};
  EXPECT_THAT(message(view), ::testing::HasSubstr("must be finite"));
}

TEST(OverlayRenderer, RefusesBrokenMeshesInOneSentence) {
  TriangleMesh mesh = testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 4);
  mesh.triangles[3][1] = 999;
  EXPECT_THAT(OverlayRenderer::create({{{"ribs", mesh}}, {}}).error().message,
              ::testing::HasSubstr("mesh of ribs has a triangle with vertex 999 of"));
  mesh = testing::make_sphere(Eigen::Vector3d::Zero(), 50.0, 4);
  mesh.vertices[2].x() = std::numeric_limits<float>::infinity();
  EXPECT_THAT(OverlayRenderer::create({{}, mesh}).error().message,
              ::testing::HasSubstr("not finite"));
}

TEST(OverlayRendererDeathTest, SaysWhatToInstallWhereThereIsNoEgl) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto without_driver = [] {
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent.json", 1);
    const auto renderer = OverlayRenderer::create({});
    std::cerr << (renderer ? "drew with " + (*renderer)->device() : renderer.error().message);
    std::exit(renderer ? 1 : 0);
  };
  EXPECT_EXIT(without_driver(),
              ::testing::ExitedWithCode(0),
              "no OpenGL 3.3 without a screen .tried .*; install libegl-mesa0 and libgl1-mesa-dri");
}

}  // namespace
}  // namespace mor
