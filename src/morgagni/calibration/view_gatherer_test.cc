// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/view_gatherer.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;
const PinholeCamera kCamera{640, 480, 525.0, 525.0, 319.5, 239.5, {}};

Eigen::Isometry3d moved(double x_mm, double turn_rad = 0.0, double roll_rad = 0.0) {
  return Eigen::Translation3d(x_mm, 0.0, 0.0) *
         Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ());
}

/// A view that shows skin at blocks [left, right) x [top, bottom), at one distance.
SensedSkin view(int left, int top, int right, int bottom, float z_mm) {
  SensedSkin result;
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; ++column) {
      SkinReading reading;
      reading.column = static_cast<std::uint16_t>(column);
      reading.row = static_cast<std::uint16_t>(row);
      reading.z_mm = z_mm;
      result.readings.push_back(reading);
    }
  }
  return result;
}

ViewPace::TimePoint at(int ms) {
  return ViewPace::TimePoint() + milliseconds(ms);
}

TEST(ViewPace, KeepsAFrameOnceTheCameraHasMovedOnAndTimeHasPassed) {
  ViewPace pace;
  EXPECT_TRUE(pace.wants(moved(0.0), at(0)));
  pace.keep(moved(0.0), at(0));
  EXPECT_FALSE(pace.wants(moved(0.0), at(5000))) << "it stands still";
  EXPECT_FALSE(pace.wants(moved(19.0), at(5000)));
  EXPECT_TRUE(pace.wants(moved(21.0), at(5000)));
  EXPECT_TRUE(pace.wants(moved(0.0, 4.0 * kDegree), at(5000)));
  EXPECT_FALSE(pace.wants(moved(21.0), at(600))) << "too soon";
  pace.keep(moved(0.0), at(5000));
  EXPECT_TRUE(pace.wants(moved(21.0), at(100))) << "the recording has begun anew";
}

TEST(ViewGatherer, SaysWhatTheMotionLacks) {
  ViewGatherer gatherer(kCamera);
  EXPECT_EQ(gatherer.coverage().far_mm, 0.0);
  auto first = view(60, 40, 100, 80, 700.0F);
  gatherer.add(first, at(0));
  const auto missing = gatherer.coverage().missing();
  ASSERT_EQ(missing.size(), 4U);
  EXPECT_THAT(missing[0], HasSubstr("nearer"));
  EXPECT_THAT(missing[1], HasSubstr("Roll"));
  EXPECT_THAT(missing[2], HasSubstr("top, the bottom, the left and the right of the picture"));
  EXPECT_THAT(missing[3], HasSubstr("sides"));
}

TEST(ViewGatherer, IsContentWithAGoodSweep) {
  ViewGatherer gatherer(kCamera);
  for (int i = 0; i < 8; ++i) {
    // Twice in each corner, near and far, rolled both ways, from both sides.
    auto one = i % 4 == 0   ? view(0, 0, 60, 50, 600.0F)
               : i % 4 == 1 ? view(100, 70, 160, 120, 850.0F)
               : i % 4 == 2 ? view(0, 70, 60, 120, 700.0F)
                            : view(100, 0, 160, 50, 700.0F);
    one.ct_from_depth = moved(30.0 * i, 35.0 * kDegree * (i % 3 - 1), 20.0 * kDegree * (i % 2));
    one.ct_from_depth.rotate(
        Eigen::AngleAxisd(-10.0 * kDegree * (i % 3), Eigen::Vector3d::UnitZ()));
    gatherer.add(one, at(1000 * i));
  }
  const auto coverage = gatherer.coverage();
  EXPECT_THAT(coverage.missing(), testing::IsEmpty());
  EXPECT_FLOAT_EQ(static_cast<float>(coverage.far_mm - coverage.near_mm), 250.0F);
  EXPECT_EQ(coverage.views_in_part[0], 2);
  EXPECT_EQ(coverage.views_in_part[4], 0) << "nothing was in the middle";
}

TEST(ViewGatherer, TheSidesAreToldFromEachOtherNotFromTheFirstView) {
  ViewGatherer gatherer(kCamera);
  for (const double turn : {0.0, -50.0, 50.0}) {
    auto one = view(0, 0, 160, 120, 700.0F);
    one.ct_from_depth = moved(0.0, turn * kDegree);
    gatherer.add(one, at(0));
  }
  EXPECT_NEAR(gatherer.coverage().turn_rad, 100.0 * kDegree, 1e-9);
}

TEST(ViewGatherer, ForgetsTheOldest) {
  ViewGatherer gatherer(kCamera);
  for (int i = 0; i < 5; ++i) {
    gatherer.add(view(0, 0, 160, 120, 500.0F + 100.0F * static_cast<float>(i)), at(1000 * i));
  }
  gatherer.drop_oldest(3);
  EXPECT_EQ(gatherer.views().size(), 2U);
  EXPECT_FLOAT_EQ(static_cast<float>(gatherer.coverage().near_mm), 800.0F);
  EXPECT_EQ(gatherer.coverage().views_in_part[8], 2);
  gatherer.drop_oldest(9);
  EXPECT_TRUE(gatherer.views().empty());
}

}  // namespace
}  // namespace mor
