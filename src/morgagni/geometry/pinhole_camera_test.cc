// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/pinhole_camera.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

constexpr PinholeCamera kCamera{
    640, 480, 525.0, 520.0, 319.5, 239.5, {0.2, -0.3, 0.001, -0.002, 0.1}};

TEST(PinholeCamera, RayUndoesProjectionWithDistortion) {
  for (double y = 0.0; y < 480.0; y += 53.0) {
    for (double x = 0.0; x < 640.0; x += 61.0) {
      const Eigen::Vector2d ray = kCamera.ray({x, y});
      const auto back = kCamera.project(700.0 * Eigen::Vector3d(ray.x(), ray.y(), 1.0));
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Eigen::Vector2d(x, y)).norm(), 1e-6);
    }
  }
}

TEST(PinholeCamera, SeesNothingBehindIt) {
  EXPECT_FALSE(kCamera.project({0.0, 0.0, -5.0}));
  EXPECT_FALSE(kCamera.project({0.0, 0.0, 0.0}));
}

TEST(PinholeCamera, AScaledPictureShowsThePointAtTheScaledPlace) {
  const PinholeCamera half = kCamera.scaled(0.5);
  const Eigen::Vector3d point(40.0, -70.0, 600.0);
  const Eigen::Vector2d corner(0.5, 0.5);
  EXPECT_LT(((*half.project(point) + corner) - 0.5 * (*kCamera.project(point) + corner)).norm(),
            1e-9);
  EXPECT_EQ(half.width_px, 320);
}

TEST(PinholeCamera, CheckNamesWhatIsWrong) {
  EXPECT_TRUE(kCamera.check());
  PinholeCamera bad = kCamera;
  bad.focal_x_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(bad.check().error().message, testing::HasSubstr("focal"));
  bad = kCamera;
  bad.width_px = 0;
  EXPECT_THAT(bad.check().error().message, testing::HasSubstr("got 0 x 480"));
}

}  // namespace
}  // namespace mor
