// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/depth_pick.h"

#include <gtest/gtest.h>

namespace mor {
namespace {

/// A wall at 700 mm with a block at 500 mm in its right half, seen by cameras 25 mm apart.
RgbdFrame wall_with_block() {
  auto calibration = std::make_shared<RgbdCalibration>();
  calibration->depth = {160, 120, 150.0, 150.0, 79.5, 59.5, {}};
  calibration->color = calibration->depth;
  calibration->color_from_depth.translation().x() = -25.0;
  RgbdFrame frame;
  frame.calibration = calibration;
  frame.depth_mm = Image<std::uint16_t>(160, 120, 700);
  frame.color = Image<Rgb8>(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 100; x < 160; ++x) frame.depth_mm(x, y) = 500;
  }
  return frame;
}

TEST(DepthPick, FindsThePointThatTheColourCameraSees) {
  const RgbdFrame frame = wall_with_block();
  const auto point = depth_point_at(frame, {40.0, 60.0});
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->z(), 700.0, 1e-9);
  const auto pixel = frame.calibration->color.project(frame.calibration->color_from_depth * *point);
  EXPECT_LT((*pixel - Eigen::Vector2d(40.0, 60.0)).norm(), 0.6);
}

TEST(DepthPick, TakesTheSurfaceInFrontAtAnEdge) {
  const RgbdFrame frame = wall_with_block();
  const Eigen::Vector3d edge(500.0 * (100.0 - 79.5) / 150.0, 0.0, 500.0);
  const auto pixel = frame.calibration->color.project(frame.calibration->color_from_depth * edge);
  const auto point = depth_point_at(frame, *pixel);
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->z(), 500.0, 1e-9);
}

TEST(DepthPick, FindsNothingWithoutReadings) {
  RgbdFrame frame = wall_with_block();
  frame.depth_mm = Image<std::uint16_t>(160, 120, 0);
  EXPECT_FALSE(depth_point_at(frame, {40.0, 60.0}));
  EXPECT_FALSE(depth_point_at(wall_with_block(), {-500.0, 60.0}));
}

}  // namespace
}  // namespace mor
