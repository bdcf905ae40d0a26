// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/start.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

const Eigen::AlignedBox3f kBody(Eigen::Vector3f(-200.0F, -150.0F, -400.0F),
                                Eigen::Vector3f(180.0F, 90.0F, 200.0F));

std::vector<LandmarkPair> landmarks(const Eigen::Isometry3d& ct_from_depth) {
  std::vector<LandmarkPair> pairs;
  for (const auto& depth : {Eigen::Vector3d(0.0, 10.0, 600.0),
                            Eigen::Vector3d(80.0, -20.0, 640.0),
                            Eigen::Vector3d(-60.0, 90.0, 650.0)}) {
    pairs.push_back({ct_from_depth * depth, depth});
  }
  return pairs;
}

TEST(StartFromLandmarks, FindsTheExactPoseFromExactPairs) {
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.linear() = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).matrix();
  truth.translation() = Eigen::Vector3d(100.0, -700.0, 30.0);
  const auto start = start_from_landmarks(landmarks(truth));
  ASSERT_TRUE(start) << start.error().message;
  EXPECT_TRUE(start->ct_from_depth.isApprox(truth, 1e-9));
  EXPECT_LT(start->fre_mm, 1e-9);
}

TEST(StartFromLandmarks, ReportsEachResidualInOrderAndTheirRootMeanSquare) {
  auto pairs = landmarks(Eigen::Isometry3d::Identity());
  pairs.push_back({{30.0, 30.0, 700.0}, {30.0, 30.0, 700.0}});
  pairs[1].ct.z() += 12.0;
  const auto start = start_from_landmarks(pairs);
  ASSERT_TRUE(start);
  ASSERT_EQ(start->residuals_mm.size(), 4U);
  double sum_sq = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(start->residuals_mm[i],
                (start->ct_from_depth * pairs[i].depth - pairs[i].ct).norm(),
                1e-12);
    sum_sq += start->residuals_mm[i] * start->residuals_mm[i];
  }
  EXPECT_GT(start->fre_mm, 0.5);
  EXPECT_NEAR(start->fre_mm, std::sqrt(sum_sq / 4.0), 1e-12);
}

TEST(StartFromLandmarks, RefusesTooFewCollinearAndNan) {
  auto pairs = landmarks(Eigen::Isometry3d::Identity());
  auto refused = start_from_landmarks({pairs[0], pairs[1]});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("at least 3"));
  std::vector<LandmarkPair> line;
  for (int i = 0; i < 4; ++i) line.push_back({{10.0 * i, 5.0 * i, 600.0}, {10.0 * i, 0.0, 600.0}});
  refused = start_from_landmarks(line);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("one line"));
  pairs[2].depth.x() = std::nan("");
  refused = start_from_landmarks(pairs);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("finite"));
}

TEST(PlaceInFrontOfCamera, PutsTheBodysCentreOnTheAxisAtTheDistance) {
  for (const auto side :
       {BodySide::kAnterior, BodySide::kPosterior, BodySide::kLeft, BodySide::kRight}) {
    const auto pose = place_in_front_of_camera(kBody, {.distance_mm = 550.0, .side = side});
    ASSERT_TRUE(pose) << pose.error().message;
    EXPECT_NEAR(pose->linear().determinant(), 1.0, 1e-12);
    const Eigen::Vector3d center = pose->inverse() * kBody.center().cast<double>();
    EXPECT_NEAR(center.x(), 0.0, 1e-9);
    EXPECT_NEAR(center.y(), 0.0, 1e-9);
    // The nearest face of the bounds is at the distance asked for.
    double nearest_mm = 1e9;
    for (const auto corner : {Eigen::AlignedBox3f::BottomLeftFloor,
                              Eigen::AlignedBox3f::BottomRightCeil,
                              Eigen::AlignedBox3f::TopLeftFloor,
                              Eigen::AlignedBox3f::TopRightCeil}) {
      const Eigen::Vector3d p = pose->inverse() * kBody.corner(corner).cast<double>();
      nearest_mm = std::min(nearest_mm, p.z());
    }
    EXPECT_NEAR(nearest_mm, 550.0, 1e-6);
  }
}

TEST(PlaceInFrontOfCamera, TurnsTheSideToTheCameraWithTheHeadUp) {
  // LPS: the front of the body is -y, its left +x, its head +z.
  const auto towards_camera = [](BodySide side) {
    const auto pose = place_in_front_of_camera(kBody, {.side = side});
    return Eigen::Vector3d(-pose->linear().col(2));
  };
  EXPECT_TRUE(towards_camera(BodySide::kAnterior).isApprox(-Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(towards_camera(BodySide::kPosterior).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(towards_camera(BodySide::kLeft).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(towards_camera(BodySide::kRight).isApprox(-Eigen::Vector3d::UnitX()));
  const Eigen::Isometry3d front = *place_in_front_of_camera(kBody, {});
  const Eigen::Vector3d head = front.inverse().linear() * Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(head.isApprox(-Eigen::Vector3d::UnitY()));  // Up in the picture.
  // Seen from the front, the body's left side is on the picture's right.
  const Eigen::Vector3d left = front.inverse().linear() * Eigen::Vector3d::UnitX();
  EXPECT_TRUE(left.isApprox(Eigen::Vector3d::UnitX()));
}

TEST(PlaceInFrontOfCamera, RollsAboutTheViewingAxis) {
  const Eigen::Isometry3d rolled =
      *place_in_front_of_camera(kBody, {.roll_rad = std::numbers::pi / 2.0});
  const Eigen::Isometry3d upright = *place_in_front_of_camera(kBody, {});
  EXPECT_TRUE(rolled.linear().col(2).isApprox(upright.linear().col(2)));
  EXPECT_TRUE(rolled.translation().isApprox(upright.translation()));
  EXPECT_TRUE(rolled.linear().col(0).isApprox(upright.linear().col(1)));
}

TEST(PlaceInFrontOfCamera, RefusesBadValues) {
  const auto message = [](const Eigen::AlignedBox3f& bounds, const PlacementOptions& options) {
    const auto pose = place_in_front_of_camera(bounds, options);
    return pose ? std::string() : pose.error().message;
  };
  EXPECT_THAT(message(kBody, {.distance_mm = 50.0}), HasSubstr("[100, 3000], got 50"));
  EXPECT_THAT(message(kBody, {.distance_mm = std::nan("")}), HasSubstr("distance_mm"));
  EXPECT_THAT(message(kBody, {.roll_rad = std::nan("")}), HasSubstr("roll_rad"));
  EXPECT_THAT(message(Eigen::AlignedBox3f(), {}), HasSubstr("bounds"));
}

}  // namespace
}  // namespace mor
