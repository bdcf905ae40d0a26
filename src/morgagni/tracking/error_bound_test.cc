// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/error_bound.h"

#include <cmath>
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

PoseInformation information(const Matrix6d& matrix) {
  return {
      .matrix = matrix, .pivot_mm = {10.0, -20.0, 30.0}, .residual_scale = 1.0, .num_pairs = 1000};
}

constexpr BoundCalibration kPlain{
    .correlated_readings = 1.0, .systematic_mm = 0.0, .floor_mm = 0.0};

/// Some symmetric positive matrix with directions of very different strength.
Matrix6d lopsided() {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Matrix6d mixed;
  for (int i = 0; i < 36; ++i) mixed(i / 6, i % 6) = normal(random);
  Eigen::Matrix<double, 6, 1> strength;
  strength << 4e4, 9e4, 3e5, 2.0, 9.0, 40.0;
  const Eigen::Matrix<double, 6, 1> root = strength.cwiseSqrt();
  return root.asDiagonal() * (Matrix6d::Identity() + 0.05 * (mixed + mixed.transpose())) *
         root.asDiagonal();
}

TEST(PoseCovariance, IsTheInverseInformationWhenReadingsAreIndependent) {
  const Matrix6d matrix = lopsided();
  const auto pose = pose_covariance(information(matrix), kPlain);
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->matrix * matrix - Matrix6d::Identity()).norm(), 1e-8);
}

TEST(PoseCovariance, GrowsWithTheResidualAndTheReadingsThatCountAsOne) {
  auto data = information(lopsided());
  const auto plain = pose_covariance(data, kPlain);
  data.residual_scale = 2.0;
  auto calibration = kPlain;
  calibration.correlated_readings = 5.0;
  const auto grown = pose_covariance(data, calibration);
  EXPECT_NEAR((grown->matrix - 20.0 * plain->matrix).norm(), 0.0, 1e-6 * grown->matrix.norm());
  data.residual_scale = 0.5;
  EXPECT_NEAR(pose_covariance(data, kPlain)->matrix.norm(), plain->matrix.norm(), 1e-9)
      << "a small residual is luck, not knowledge";
}

TEST(PoseCovariance, GrowsWithWhatIsNotExplained) {
  auto data = information(lopsided());
  auto calibration = kPlain;
  calibration.clutter_growth = 2.0;
  const auto plain = pose_covariance(data, calibration);
  data.unexplained_fraction = 0.5;
  const auto cluttered = pose_covariance(data, calibration);
  EXPECT_NEAR(
      (cluttered->matrix - 2.0 * plain->matrix).norm(), 0.0, 1e-6 * cluttered->matrix.norm());
}

TEST(PoseCovariance, ASystematicErrorDoesNotAverageOut) {
  auto calibration = kPlain;
  calibration.systematic_mm = 0.5;
  const Matrix6d few = lopsided();
  const auto with_few = pose_covariance(information(few), calibration);
  const auto with_many = pose_covariance(information(1e4 * few), calibration);
  const Eigen::Vector3d point(10.0, -20.0, 30.0);
  EXPECT_GT(error_bound_mm(*with_many, point), 0.5) << "at least the error itself";
  EXPECT_LT(error_bound_mm(*with_many, point), error_bound_mm(*with_few, point));
}

TEST(PoseCovariance, AToldBiasWidensTheBoundInProportion) {
  const auto data = information(1e4 * lopsided());
  const auto bound_mm = [&](double bias_mm, double distance_mm) {
    return error_bound_mm(*pose_covariance(data, with_sensor_bias(kPlain, bias_mm, distance_mm)),
                          {60.0, 0.0, 0.0});
  };
  EXPECT_NEAR(bound_mm(4.0, 600.0) / bound_mm(2.0, 600.0), 2.0, 0.1);
  EXPECT_EQ(bound_mm(2.0, 600.0), bound_mm(2.0, 800.0)) << "nearer it is taken as told";
  EXPECT_NEAR(bound_mm(2.0, 1200.0) / bound_mm(2.0, 800.0), 1.5, 0.1);
  EXPECT_EQ(with_sensor_bias(kPlain, 0.0, 800.0).systematic_mm, kPlain.systematic_mm);
}

TEST(PoseCovariance, IsNoneWhereADirectionIsOpen) {
  Matrix6d matrix = Matrix6d::Identity() * 1e4;
  matrix(4, 4) = 0.0;
  EXPECT_FALSE(pose_covariance(information(matrix), kPlain));
  EXPECT_FALSE(pose_covariance(information(Matrix6d::Zero()), kPlain));
  matrix(4, 4) = std::nan("");
  EXPECT_FALSE(pose_covariance(information(matrix), kPlain));
}

TEST(ErrorBound, IsExactWhereTheErrorHasOneSizeInItsDirections) {
  PoseCovariance pose;
  pose.matrix(3, 3) = 4.0;
  EXPECT_NEAR(error_bound_mm(pose, pose.pivot_mm), 2.0 * 1.959964, 1e-4) << "one direction";
  pose.matrix(4, 4) = 4.0;
  EXPECT_NEAR(error_bound_mm(pose, pose.pivot_mm), 2.0 * 2.447747, 1e-4) << "two";
  pose.matrix(5, 5) = 4.0;
  EXPECT_NEAR(error_bound_mm(pose, pose.pivot_mm), 2.0 * 2.795483, 1e-4) << "three";
  EXPECT_EQ(error_bound_mm({}, {1.0, 2.0, 3.0}), 0.0);
}

/// Draws poses from the covariance, moves the point with each, and counts.
TEST(ErrorBound, HoldsInNinetyFiveOfAHundredDrawnPoses) {
  const auto pose = pose_covariance(information(lopsided()), kPlain);
  ASSERT_TRUE(pose);
  const Matrix6d root = pose->matrix.llt().matrixL();
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const Eigen::Vector3d& lever : {Eigen::Vector3d(0.0, 0.0, 0.0),
                                       Eigen::Vector3d(150.0, 0.0, 0.0),
                                       Eigen::Vector3d(-80.0, 120.0, 60.0)}) {
    const Eigen::Vector3d point = pose->pivot_mm + lever;
    const double bound_mm = error_bound_mm(*pose, point);
    constexpr int kDraws = 20000;
    int held = 0;
    for (int i = 0; i < kDraws; ++i) {
      Vector6d z;
      for (auto& value : z) value = normal(random);
      const Vector6d twist = root * z;
      const Eigen::Vector3d moved =
          se3_exp((Vector6d() << twist.head<3>(), 0, 0, 0).finished()) * lever + twist.tail<3>();
      held += (moved - lever).norm() <= bound_mm ? 1 : 0;
    }
    EXPECT_NEAR(static_cast<double>(held) / kDraws, 0.95, 0.008) << lever.transpose();
  }
}

}  // namespace
}  // namespace mor
