// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The free view as it looked when somebody last judged it (testdata/render); made anew like the
// pictures of golden_pictures_test.
#include <array>
#include <memory>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "morgagni/render/free_view.h"
#include "morgagni/render/testing/golden_picture.h"
#include "morgagni/render/testing/small_body.h"

namespace mor {
namespace {

constexpr PinholeCamera kColorCamera{
    160, 120, 148.0, 149.0, 80.5, 58.0, {-0.12, 0.04, 0.001, 0, 0}};
constexpr PinholeCamera kVirtualCamera{160, 120, 150.0, 150.0, 79.5, 59.5, {}};

/// Squares of two skin tones, with a blue one at the picture's left: the sides are told apart.
Image<Rgb8> checkered() {
  Image<Rgb8> picture(kColorCamera.width_px, kColorCamera.height_px);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const bool is_light = (x / 10 + y / 10) % 2 == 0;
      picture(x, y) = is_light ? Rgb8{224, 178, 150} : Rgb8{186, 128, 104};
      if (x / 10 == 5 && y / 10 == 5) picture(x, y) = {40, 70, 180};
    }
  }
  return picture;
}

/// Each triangle of the skin in a cell of its own; the back of the body was never seen.
AtlasPicture triangle_cells(const TriangleMesh& skin) {
  constexpr int kCellPx = 8;
  constexpr int kColumns = 128;
  const int rows = static_cast<int>(skin.triangles.size()) / kColumns + 1;
  auto surface = std::make_shared<AtlasSurface>();
  surface->mesh = skin;
  surface->width_px = kColumns * kCellPx;
  surface->height_px = rows * kCellPx;
  auto colors = std::make_shared<Image<Rgba8>>(surface->width_px, surface->height_px);
  for (std::size_t i = 0; i < skin.triangles.size(); ++i) {
    const int left = static_cast<int>(i) % kColumns * kCellPx;
    const int top = static_cast<int>(i) / kColumns * kCellPx;
    surface->corners_px.push_back({Eigen::Vector2f(left + 1, top + 1),
                                   Eigen::Vector2f(left + 6, top + 1),
                                   Eigen::Vector2f(left + 1, top + 6)});
    const Eigen::Vector3f& place = skin.vertices[skin.triangles[i][0]];
    const auto shade = static_cast<std::uint8_t>(150.0F + place.z());
    const std::uint8_t seen = place.y() < 15.0F ? 255 : 0;
    for (int y = top; y < top + kCellPx; ++y)
      for (int x = left; x < left + kCellPx; ++x)
        (*colors)(x, y) = {shade, static_cast<std::uint8_t>(shade - 40), 110, seen};
  }
  return {std::move(surface), std::move(colors)};
}

class GoldenFreeView : public ::testing::Test {
 protected:
  GoldenFreeView() {
    view_.camera = kVirtualCamera;
    view_.view_from_ct =
        testing::small_body_pose() * Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ());
    view_.picture = {.color = color_.view(),
                     .camera = kColorCamera,
                     .color_from_ct = testing::small_body_pose()};
    view_.structure_opacity = {{"skin", 0.0F}};
  }

  void expect_looks_like(const std::string& name) {
    const auto renderer = FreeViewRenderer::create(scene_);
    ASSERT_TRUE(renderer) << renderer.error().message;
    const auto drawn = (*renderer)->render(view_);
    ASSERT_TRUE(drawn) << drawn.error().message;
    testing::expect_golden(name, testing::without_alpha(drawn->picture));
  }

  const RenderScene scene_ = testing::small_body();
  const Image<Rgb8> color_ = checkered();
  FreeView view_;
};

TEST_F(GoldenFreeView, CutsAwayWhatTheCameraDoesNotSee) {
  expect_looks_like("free-view");
}

TEST_F(GoldenFreeView, HatchesBareSkin) {
  view_.shows_bare_skin = true;
  expect_looks_like("free-view-bare-skin");
}

TEST_F(GoldenFreeView, OpensTheHoleInTheSkin) {
  view_.picture->hole = {.radius = 0.2F};
  expect_looks_like("free-view-hole");
}

TEST_F(GoldenFreeView, WearsAnAtlas) {
  view_.picture.reset();
  view_.atlas = triangle_cells(scene_.skin);
  view_.shows_bare_skin = true;
  expect_looks_like("free-view-atlas");
}

}  // namespace
}  // namespace mor
