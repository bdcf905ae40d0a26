// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Meshes as files bring them, views as fingers make them, cameras of odd sizes.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/render/internal/gl_structure.h"
#include "morgagni/render/testing/small_body.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{320, 240, 280.0, 280.0, 159.5, 119.5, {}};

OverlayView everywhere() {
  return {.color_camera = kCamera,
          .color_from_ct = testing::at(0.0, 0.0, 300.0),
          .opacity = 1.0F,
          .hole = {.radius = 2.0F}};
}

Image<Rgba8> drawn(const TriangleMesh& mesh) {
  const auto renderer = testing::make_renderer(
      {.structures = {{"thing", mesh, {1, 0, 0}}}, .skin = {}, .volume = {}});
  const Image<Rgb8> color(kCamera.width_px, kCamera.height_px, Rgb8{100, 100, 100});
  return testing::rendered(*renderer, color, everywhere());
}

int num_red(const Image<Rgba8>& picture) {
  return static_cast<int>(std::count_if(picture.data(),
                                        picture.data() + picture.size(),
                                        [](const Rgba8& pixel) { return pixel.g < 25; }));
}

TriangleMesh ball() {
  return testing::make_sphere(Eigen::Vector3d::Zero(), 60.0, 40);
}

TEST(HostileMesh, FlatAndRepeatedTrianglesAreNotSeen) {
  TriangleMesh mesh = ball();
  const int clean = num_red(drawn(mesh));
  for (std::uint32_t i = 0; i < 900; i += 3) {
    mesh.triangles.push_back({i, i, i + 1});
    mesh.triangles.push_back({i, i, i});
  }
  EXPECT_EQ(num_red(drawn(mesh)), clean);
}

TEST(HostileMesh, ThreeTrianglesOnAnEdgeAndHolesAreDrawnAsTheyAre) {
  TriangleMesh mesh = ball();
  const int clean = num_red(drawn(mesh));
  // A fin across the ball, on edges that have two triangles already.
  const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(100.0F, 0.0F, 0.0F);
  mesh.normals.emplace_back(0.0F, 0.0F, -1.0F);
  for (int i = 0; i < 40; ++i) {
    const auto [a, b, c] = mesh.triangles[static_cast<std::size_t>(i) * 37];
    mesh.triangles.push_back({a, b, tip});
  }
  EXPECT_FALSE(internal::is_closed(mesh));
  EXPECT_GT(num_red(drawn(mesh)), clean);
  mesh = ball();
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    return mesh.vertices[triangle[0]].z() < 0.0F;  // The half that faces the camera.
  });
  EXPECT_NEAR(num_red(drawn(mesh)), clean, 0.1 * clean) << "the other half, from inside";
}

TEST(HostileMesh, NormalsWithoutADirectionAreReplaced) {
  TriangleMesh mesh = ball();
  const auto clean = drawn(mesh);
  for (std::size_t i = 0; i < mesh.normals.size(); i += 3) {
    const float bad = i % 2 == 0 ? 0.0F : std::numeric_limits<float>::quiet_NaN();
    mesh.normals[i].setConstant(bad);
  }
  const auto mended = drawn(mesh);
  double off = 0.0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    off = std::max(off, std::abs(1.0 * clean.data()[i].r - mended.data()[i].r));
  }
  EXPECT_LE(off, 6.0);
}

TEST(HostileMesh, AMillionTrianglesAreDrawnAsAFew) {
  constexpr std::size_t kMost = 40000;
  TriangleMesh mesh = testing::make_torus(Eigen::Vector3d::Zero(), 50.0, 20.0, 1000, 500);
  ASSERT_EQ(mesh.triangles.size(), 1000000U);
  EXPECT_LE(internal::level_of_detail(mesh, kMost).triangles.size(), kMost * 6 / 5);
  // The same as an STL file has it, no triangle knowing of another.
  TriangleMesh loose;
  for (const Triangle& triangle : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (const auto corner : triangle) loose.vertices.push_back(mesh.vertices[corner]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_LE(internal::level_of_detail(loose, kMost).triangles.size(), kMost * 6 / 5);
  // Pieces that touch nowhere.
  for (std::size_t i = 0; i < loose.triangles.size(); ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      loose.vertices[3 * i + j] *= 1.0F + 1e-5F * static_cast<float>(i % 1000);
    }
  }
  EXPECT_LE(internal::level_of_detail(loose, kMost).triangles.size(), kMost * 6 / 5);
}

TEST(HostileMesh, ASplinterBesideLargeStructuresIsStillThere) {
  const TriangleMesh splinter = testing::make_sphere({60.0, 0.0, 0.0}, 3.0, 12);
  const RenderScene scene{.structures = {{"body", testing::make_bones(400000), {0, 0, 1}},
                                         {"splinter", splinter, {1, 0, 0}}},
                          .skin = {},
                          .volume = {}};
  const auto renderer = testing::make_renderer(scene);
  OverlayView view = everywhere();
  view.structure_opacity = {{"body", 0.0F}};
  const Image<Rgb8> color(kCamera.width_px, kCamera.height_px, Rgb8{100, 100, 100});
  const double radius_px = 3.0 * 280.0 / 300.0;
  EXPECT_NEAR(
      num_red(testing::rendered(*renderer, color, view)), 3.14 * radius_px * radius_px, 8.0);
}

TEST(HostileView, AVolumesWindowIsNotInverted) {
  const auto renderer = testing::make_renderer(testing::small_body());
  OverlayView view = everywhere();
  const Image<Rgb8> color(kCamera.width_px, kCamera.height_px);
  for (const float window_hu : {-400.0F, 0.0F, std::numeric_limits<float>::quiet_NaN()}) {
    view.volume = {VolumePreset::kBone, 400.0F, window_hu};
    const auto refused = renderer->render(color.view(), view);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, ::testing::HasSubstr("must be wider than 0 HU"));
  }
}

/// Everything at once in a picture of any size; beside the body it stays as it is.
TEST(HostileView, OddPicturesShowEveryMode) {
  const auto renderer = testing::make_renderer(testing::small_body());
  for (const PinholeCamera& camera :
       {PinholeCamera{641, 479, 500.0, 500.0, 318.0, 242.0, {0.05, -0.1, 0, 0, 0}},
        PinholeCamera{1920, 1080, 1100.0, 1100.0, 950.0, 545.0, {-0.1, 0.02, 0, 0, 0}},
        PinholeCamera{37, 23, 25.0, 25.0, 18.0, 11.0, {}}}) {
    const Image<Rgb8> color(camera.width_px, camera.height_px, Rgb8{100, 100, 100});
    OverlayView view = everywhere();
    view.color_camera = camera;
    view.color_from_ct = testing::small_body_pose();
    view.has_outlines = true;
    view.structure_opacity = {{"skin", 0.3F}, {"heart", 0.5F}};
    view.slice.plane = SlicePlane::kCoronal;
    for (const auto preset : {VolumePreset::kNone, VolumePreset::kBone, VolumePreset::kLung}) {
      const auto [level_hu, window_hu] = volume_window(preset);
      view.volume = {preset, level_hu, window_hu};
      for (const float radius : {0.3F, 2.0F}) {
        view.hole.radius = radius;
        const auto picture = testing::rendered(*renderer, color, view);
        EXPECT_EQ(picture(0, 0), (Rgba8{100, 100, 100, 255}));
        EXPECT_NE(picture(camera.width_px / 2, camera.height_px / 2), (Rgba8{100, 100, 100, 255}))
            << camera.width_px << " px, " << to_string(preset) << ", hole " << radius;
      }
    }
  }
}

}  // namespace
}  // namespace mor
