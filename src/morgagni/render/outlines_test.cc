// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Lines where a structure is hidden: a ball, whose outline is known, behind a slice and beside the
// hole.
#include <cmath>

#include <gtest/gtest.h>

#include "morgagni/render/overlay_renderer.h"
#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{321, 239, 270.0, 268.0, 158.0, 121.0, {0.05, -0.08, 0, 0, 0}};
const Eigen::Vector3d kCenter(8.0, -5.0, 300.0);  ///< Frame colour.
constexpr double kBallMm = 40.0;

class OutlinesTest : public ::testing::Test {
 protected:
  OverlayView view(float hole_radius) const {
    return {.color_camera = kCamera,
            .color_from_ct = testing::at(kCenter.x(), kCenter.y(), kCenter.z()),
            .opacity = 1.0F,
            .hole = {.radius = hole_radius},
            .has_outlines = true};
  }

  Image<Rgba8> drawn(const OverlayView& view) const {
    return testing::rendered(*renderer_, color_, view);
  }

  /// In px, signed: beyond the ball's outline.
  static double beyond_px(int x, int y) {
    const Eigen::Vector3d ray = kCamera.ray(Eigen::Vector2d(x, y)).homogeneous().normalized();
    const double away_mm = kCenter.norm();
    const double angle = std::acos(std::min(1.0, ray.dot(kCenter.normalized())));
    return (angle - std::asin(kBallMm / away_mm)) * kCamera.focal_y_px;
  }

  const Image<Rgb8> color_{kCamera.width_px, kCamera.height_px, Rgb8{100, 100, 100}};
  const std::shared_ptr<const Volume> solid_ =
      testing::make_volume(160, [](const Eigen::Vector3d&) { return 40.0; });
  const std::unique_ptr<OverlayRenderer> renderer_ = testing::make_renderer(
      {.structures = {{"ball",
                       testing::make_sphere(Eigen::Vector3d::Zero(), kBallMm, 60),
                       {0.1F, 0.9F, 0.1F}}},
       .skin = testing::make_sphere(Eigen::Vector3d::Zero(), 95.0, 60),
       .volume = solid_});
};

TEST_F(OutlinesTest, BesideTheHoleTheyLieUnderTheSkinWhereTheStructureEnds) {
  // A hole that is nowhere near the ball.
  OverlayView hole = view(0.05F);
  hole.hole.center = {0.05F, 0.05F};
  const auto picture = drawn(hole);
  int num_on = 0;
  for (int y = 2; y < kCamera.height_px - 2; ++y) {
    for (int x = 60; x < kCamera.width_px - 2; ++x) {
      const bool is_line = picture(x, y).g > picture(x, y).r + 15;
      const double beyond = beyond_px(x, y);
      if (std::abs(beyond + 0.5) < 0.3) {
        EXPECT_TRUE(is_line) << x << ", " << y;
        ++num_on;
      }
      if (std::abs(beyond + 0.5) > 2.6) {
        ASSERT_EQ(picture(x, y), (Rgba8{100, 100, 100, 255})) << x << ", " << y;
      }
    }
  }
  EXPECT_GT(num_on, 80);
}

TEST_F(OutlinesTest, WhatIsSeenKeepsItsLook) {
  OverlayView open = view(2.0F);
  const auto with = drawn(open);
  open.has_outlines = false;
  EXPECT_EQ(with, drawn(open));
}

TEST_F(OutlinesTest, BehindASliceTheyAreDrawnOverIt) {
  OverlayView open = view(2.0F);
  open.slice = {.plane = SlicePlane::kCamera, .depth_mm = 25.0F, .cuts = false};
  const auto with = drawn(open);
  open.has_outlines = false;
  const auto without = drawn(open);
  int num_changed = 0;
  for (int y = 2; y < kCamera.height_px - 2; ++y) {
    for (int x = 2; x < kCamera.width_px - 2; ++x) {
      if (with(x, y) == without(x, y)) continue;
      ASSERT_LT(std::abs(beyond_px(x, y) + 0.5), 2.6) << x << ", " << y;
      ++num_changed;
    }
  }
  EXPECT_GT(num_changed, 300);
}

TEST_F(OutlinesTest, AStructureThatIsOffHasNone) {
  OverlayView hole = view(0.05F);
  hole.hole.center = {0.05F, 0.05F};
  hole.structure_opacity = {{"ball", 0.0F}};
  const auto with = drawn(hole);
  hole.has_outlines = false;
  EXPECT_EQ(with, drawn(hole));
}

TEST_F(OutlinesTest, AHandIsBeforeThem) {
  OverlayView hole = view(0.05F);
  hole.hole.center = {0.05F, 0.05F};
  Image<std::uint16_t> depth(kCamera.width_px, kCamera.height_px, 180);
  PinholeCamera straight = kCamera;
  straight.distortion = {};
  hole.measured = MeasuredDepth{depth.view(), straight, Eigen::Isometry3d::Identity()};
  const auto picture = drawn(hole);
  for (int y = 0; y < kCamera.height_px; ++y) {
    for (int x = 60; x < kCamera.width_px; ++x) {
      ASSERT_EQ(picture(x, y), (Rgba8{100, 100, 100, 255})) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace mor
