// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/rigid.h"

#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

struct Pairs {
  std::vector<Eigen::Vector3d> fixed;
  std::vector<Eigen::Vector3d> moving;
};

Pairs make_pairs(const Eigen::Isometry3d& fixed_from_moving, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> spread(0.0, 100.0);
  Pairs pairs;
  for (int i = 0; i < count; ++i) {
    pairs.moving.emplace_back(spread(random), spread(random), spread(random));
    pairs.fixed.push_back(fixed_from_moving * pairs.moving.back());
  }
  return pairs;
}

TEST(FitRigid, RecoversAnyMotionFromExactPairs) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> any;
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
    truth.linear() = Eigen::Quaterniond(any(random), any(random), any(random), any(random))
                         .normalized()
                         .toRotationMatrix();
    truth.translation() = 300.0 * Eigen::Vector3d(any(random), any(random), any(random));
    const auto pairs = make_pairs(truth, 3 + static_cast<int>(seed % 7), seed);
    const auto found = fit_rigid(pairs.fixed, pairs.moving);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT((found->matrix() - truth.matrix()).norm(), 1e-9);
  }
}

TEST(FitRigid, NeverMirrors) {
  auto pairs = make_pairs(Eigen::Isometry3d::Identity(), 20, 1);
  for (auto& point : pairs.fixed) point.x() = -point.x();
  const auto found = fit_rigid(pairs.fixed, pairs.moving);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->linear().determinant(), 1.0, 1e-12);
}

TEST(FitRigid, RefusesPointsOnALine) {
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {-3, -6, -9}};
  const auto found = fit_rigid(line, line);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("on one line"));
}

TEST(FitRigid, RefusesTwoPairsAndNumbersThatDiffer) {
  const std::vector<Eigen::Vector3d> two = {{0, 0, 0}, {1, 0, 0}};
  const std::vector<Eigen::Vector3d> three = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_THAT(fit_rigid(two, two).error().message, HasSubstr("at least 3"));
  EXPECT_THAT(fit_rigid(two, three).error().message, HasSubstr("got 2 and 3"));
}

TEST(Se3Exp, TurnsAboutTheAxisByTheAngle) {
  Vector6d twist = Vector6d::Zero();
  twist[2] = std::numbers::pi / 2.0;
  const Eigen::Vector3d turned = se3_exp(twist) * Eigen::Vector3d(1.0, 0.0, 0.0);
  EXPECT_LT((turned - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), 1e-12);
}

TEST(Se3Exp, SeriesAndClosedFormMeet) {
  Vector6d twist;
  twist << 0.6e-4, -0.5e-4, 0.6e-4, 10.0, 20.0, -30.0;
  const Eigen::Isometry3d half = se3_exp(0.5 * twist);
  EXPECT_LT((se3_exp(twist).matrix() - (half * half).matrix()).norm(), 1e-10);
  EXPECT_LT((se3_exp(1e3 * twist).matrix() - (se3_exp(5e2 * twist) * se3_exp(5e2 * twist)).matrix())
                .norm(),
            1e-7);
}

TEST(Displacement, IsWhatAPointMoves) {
  Eigen::Isometry3d shifted = Eigen::Isometry3d::Identity();
  shifted.translation().x() = 3.0;
  EXPECT_DOUBLE_EQ(displacement_mm(Eigen::Isometry3d::Identity(), shifted, {5.0, 6.0, 7.0}), 3.0);
}

}  // namespace
}  // namespace mor
