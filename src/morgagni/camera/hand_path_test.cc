// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/hand_path.h"

#include <numbers>

#include <gtest/gtest.h>

#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/rigid.h"

namespace mor::internal {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

const Eigen::AlignedBox3f kHead(Eigen::Vector3f(-40.0F, -200.0F, -5.0F),
                                Eigen::Vector3f(120.0F, -40.0F, 155.0F));

TEST(HandPath, StartsInFrontOfTheBodyWithItsHeadUp) {
  // The virtual placement: on the anterior side, looking to the back, feet towards the bottom.
  Eigen::Isometry3d placed = Eigen::Isometry3d::Identity();
  placed.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  placed.translation() << 40.0, -200.0 - 600.0, 75.0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto start = HandPath(kHead, 600.0, SimulatedPath::kOrbit, seed).ct_from_camera(0.0);
    EXPECT_LT((start.translation() - placed.translation()).norm(), 60.0);
    EXPECT_LT(rotation_angle_rad(placed.inverse() * start), 6.0 * kDegree);
  }
}

TEST(HandPath, MovesNoFasterThanACarefulHandAndKeepsTheBodyInView) {
  const PinholeCamera camera{.width_px = 640,
                             .height_px = 480,
                             .focal_x_px = 525.0,
                             .focal_y_px = 525.0,
                             .center_x_px = 319.5,
                             .center_y_px = 239.5};
  constexpr double kStepS = 1.0 / 30.0;
  for (const auto path :
       {SimulatedPath::kOrbit, SimulatedPath::kSway, SimulatedPath::kPass, SimulatedPath::kSweep}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const HandPath hand(kHead, 700.0, path, seed);
      double travelled_mm = 0.0;
      for (int i = 0; i < 30 * 120; ++i) {
        const auto now = hand.ct_from_camera(i * kStepS);
        const auto next = hand.ct_from_camera((i + 1) * kStepS);
        const double step_mm = (next.translation() - now.translation()).norm();
        ASSERT_LT(step_mm / kStepS, 150.0) << i;
        ASSERT_LT(rotation_angle_rad(now.inverse() * next) / kStepS, 20.0 * kDegree) << i;
        travelled_mm += step_mm;
        const auto middle =
            camera.project(now.inverse() * Eigen::Vector3d(kHead.center().cast<double>()));
        ASSERT_TRUE(middle);
        ASSERT_LT((*middle - Eigen::Vector2d(319.5, 239.5)).norm(), 120.0);
        ASSERT_NEAR(now.linear().determinant(), 1.0, 1e-9);
      }
      EXPECT_GT(travelled_mm, 300.0);
    }
  }
}

}  // namespace
}  // namespace mor::internal
