// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A ball for a body, and a board before it whose edges are known: what of the overlay stays?
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr PinholeCamera kColorCamera{641, 479, 530.0, 528.0, 318.0, 242.0, {0.05, -0.1, 0, 0, 0}};
constexpr PinholeCamera kDepthCamera{640, 480, 575.0, 575.0, 319.5, 239.5, {}};
constexpr double kBodyMm = 150.0;
const Eigen::Vector3d kBodyCenter(0.0, 0.0, 850.0);  // Frame depth.
constexpr Rgb8 kSkinColor{200, 150, 130};
constexpr Rgb8 kBoardColor{40, 70, 160};
constexpr Rgb8 kRoomColor{90, 90, 90};

/// An upright board facing the camera, frame depth.
struct Board {
  double distance_mm = 600.0;
  Eigen::AlignedBox2d extent_mm{Eigen::Vector2d(-20.0, -300.0), Eigen::Vector2d(45.0, 60.0)};
};

struct Hit {
  double z_mm = 0.0;  ///< Frame depth; 0: nothing.
  Rgb8 color = kRoomColor;
};

/// What a ray from `eye` meets. @param direction  With z = 1.
Hit trace(const Board& board, const Eigen::Vector3d& eye, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d on_board = eye + (board.distance_mm - eye.z()) * direction;
  if (board.extent_mm.contains(Eigen::Vector2d(on_board.head<2>()))) {
    return {board.distance_mm, kBoardColor};
  }
  const Eigen::Vector3d unit = direction.normalized();
  const double along = (kBodyCenter - eye).dot(unit);
  const double beside_sq = (kBodyCenter - eye).squaredNorm() - along * along;
  if (beside_sq > kBodyMm * kBodyMm) return {};
  const double distance = along - std::sqrt(kBodyMm * kBodyMm - beside_sq);
  return {(eye + distance * unit).z(), kSkinColor};
}

struct Look {
  Image<Rgb8> color{kColorCamera.width_px, kColorCamera.height_px};
  Image<std::uint16_t> depth{kDepthCamera.width_px, kDepthCamera.height_px};
};

Eigen::Isometry3d color_from_depth() {
  return testing::at(-25.0, 2.0, 0.0);
}

Look look_at(const Board& board, double noise_mm) {
  Look look;
  const Eigen::Vector3d eye = color_from_depth().inverse().translation();
  for (int y = 0; y < look.color.height(); ++y) {
    for (int x = 0; x < look.color.width(); ++x) {
      const Eigen::Vector2d ray = kColorCamera.ray(Eigen::Vector2d(x, y));
      look.color(x, y) = trace(board, eye, ray.homogeneous()).color;
    }
  }
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, noise_mm);
  for (int y = 0; y < look.depth.height(); ++y) {
    for (int x = 0; x < look.depth.width(); ++x) {
      const Eigen::Vector2d ray = kDepthCamera.ray(Eigen::Vector2d(x, y));
      const double z = trace(board, Eigen::Vector3d::Zero(), ray.homogeneous()).z_mm;
      if (z > 0.0) look.depth(x, y) = static_cast<std::uint16_t>(std::lround(z + noise(random)));
    }
  }
  return look;
}

class OcclusionTest : public ::testing::Test {
 protected:
  OverlayView view_of(const Look& look) const {
    const Eigen::Isometry3d depth_from_ct = testing::at(0.0, 0.0, kBodyCenter.z());
    return {.color_camera = kColorCamera,
            .color_from_ct = color_from_depth() * depth_from_ct,
            .opacity = 1.0F,
            .hole = {.radius = 2.0F},
            .measured = MeasuredDepth{look.depth.view(), kDepthCamera, color_from_depth()}};
  }

  /// Pixels inside of the body's outline, at least `margin_px` away from the board's outline, whose
  /// look is wrong: changed where the board is, unchanged where the body is.
  int num_wrong(const Look& look, const Image<Rgba8>& shown, int margin_px) const {
    int result = 0;
    for (int y = margin_px; y < look.color.height() - margin_px; ++y) {
      for (int x = margin_px; x < look.color.width() - margin_px; ++x) {
        const Rgb8 truth = look.color(x, y);
        if (truth == kRoomColor || is_near_another_color(look.color, x, y, margin_px)) continue;
        const bool is_same = shown(x, y) == Rgba8{truth.r, truth.g, truth.b, 255};
        if (is_same != (truth == kBoardColor)) ++result;
      }
    }
    return result;
  }

  static bool is_near_another_color(const Image<Rgb8>& color, int x, int y, int margin_px) {
    for (int dy = -margin_px; dy <= margin_px; dy += margin_px) {
      for (int dx = -margin_px; dx <= margin_px; dx += margin_px) {
        if (color(x + dx, y + dy) != color(x, y)) return true;
      }
    }
    return false;
  }

  const std::unique_ptr<OverlayRenderer> renderer_ = testing::make_renderer(
      {.structures = {{"bones",
                       testing::make_sphere(Eigen::Vector3d::Zero(), 148.0, 40),
                       {1, 0, 0}}},
       .skin = testing::make_sphere(Eigen::Vector3d::Zero(), kBodyMm, 80)});
};

TEST_F(OcclusionTest, WhatIsInFrontStaysInFrontToTheOutlineInTheColorPicture) {
  // The cameras stand 25 mm apart: at these distances the board is 7 px elsewhere in the depth
  // picture, relative to the body.
  const Look look = look_at(Board{}, 1.5);
  EXPECT_EQ(num_wrong(look, testing::rendered(*renderer_, look.color, view_of(look)), 4), 0);
}

TEST_F(OcclusionTest, AHandOnTheSkinIsInFront) {
  // Its front is 25 mm before the ball's foremost point; more before all others.
  const Look look = look_at({.distance_mm = 675.0}, 1.5);
  EXPECT_EQ(num_wrong(look, testing::rendered(*renderer_, look.color, view_of(look)), 4), 0);
}

TEST_F(OcclusionTest, NoiseAndAMisplacedPoseCoverNothing) {
  const Look look = look_at({.extent_mm = Eigen::AlignedBox2d()}, 4.0);
  OverlayView view = view_of(look);
  view.color_from_ct->translation().z() += 3.0;  // The skin is measured 3 mm in front of the CT's.
  OverlayView without = view;
  without.measured.reset();
  EXPECT_EQ(testing::rendered(*renderer_, look.color, view),
            testing::rendered(*renderer_, look.color, without));
}

TEST_F(OcclusionTest, ShiningMetalWithoutReadingsInsideOfAHandStaysInFront) {
  Look look = look_at(Board{}, 1.5);
  for (int y = 150; y < 240; ++y) {
    for (int x = 315; x < 345; ++x) look.depth(x, y) = 0;
  }
  EXPECT_EQ(num_wrong(look, testing::rendered(*renderer_, look.color, view_of(look)), 6), 0);
}

TEST_F(OcclusionTest, APictureWithoutAnyReadingCoversNothing) {
  Look look = look_at(Board{}, 0.0);
  look.depth = Image<std::uint16_t>(kDepthCamera.width_px, kDepthCamera.height_px);
  OverlayView without = view_of(look);
  without.measured.reset();
  EXPECT_EQ(testing::rendered(*renderer_, look.color, view_of(look)),
            testing::rendered(*renderer_, look.color, without));
}

TEST_F(OcclusionTest, RefusesADepthPictureOfAnotherSize) {
  const Look look = look_at(Board{}, 0.0);
  OverlayView view = view_of(look);
  view.measured->depth_camera.width_px = 320;
  const auto refused = renderer_->render(look.color.view(), view);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "the depth picture is 640 x 480 px, its camera 320 x 480 px");
}

}  // namespace
}  // namespace mor
