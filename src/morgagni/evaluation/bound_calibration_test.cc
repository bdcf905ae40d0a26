// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/bound_calibration.h"

#include <cmath>
#include <random>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

/// Frames whose poses are drawn from a known covariance: that of readings of which eight count as
/// one.
BoundRuns drawn(int num_frames) {
  constexpr double kCorrelated = 8.0;
  BoundRuns runs;
  runs.groups = {{"near", nullptr, "", 0.0}, {"far", nullptr, "", 0.0}};
  runs.num_frames = {num_frames, num_frames};
  runs.num_not_found = {0, 0};
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2 * num_frames; ++i) {
    BoundSample sample;
    sample.group = static_cast<std::size_t>(i % 2);
    sample.distance_mm = sample.group == 0 ? 600.0 : 1000.0;
    sample.state = TrackingState::kTracking;
    const double strength = sample.group == 0 ? 4000.0 : 500.0;
    sample.information.matrix.diagonal() << 1e4 * strength, 2e4 * strength, 5e3 * strength,
        strength, 3.0 * strength, 0.5 * strength;
    sample.information.residual_scale = 1.0;
    const Eigen::Matrix<double, 6, 6> covariance =
        kCorrelated * sample.information.matrix.inverse();
    const Eigen::Matrix<double, 6, 6> root = covariance.llt().matrixL();
    Vector6d z;
    for (auto& value : z) value = normal(random);
    const Vector6d twist = root * z;
    for (const double x_mm : {0.0, 80.0, 200.0}) {
      const Eigen::Vector3d point(x_mm, 10.0, -30.0);
      const Eigen::Vector3d off = twist.head<3>().cross(point) + twist.tail<3>();
      sample.targets.push_back({BoundTarget::Kind::kAnywhere, point, off.norm()});
    }
    runs.samples.push_back(sample);
  }
  return runs;
}

TEST(BoundCalibration, FindsHowManyReadingsCountAsOne) {
  const auto runs = drawn(400);
  const auto fitted = fit_bound_calibration(runs);
  EXPECT_NEAR(fitted.correlated_readings, 8.0, 1.6);
  EXPECT_LT(fitted.systematic_mm, 0.05);
  for (const auto& line : bound_coverage(runs, fitted)) {
    EXPECT_NEAR(line.coverage, 0.95, 0.02) << line.name;
  }
}

TEST(BoundCalibration, CountsWhatIsWithinTheBound) {
  auto runs = drawn(50);
  auto lines = bound_coverage(runs, {.correlated_readings = 8000.0});
  EXPECT_EQ(lines[0].name, "all without bias");
  EXPECT_EQ(lines[0].num_frames, 100);
  EXPECT_EQ(lines[0].num_targets, 300);
  EXPECT_EQ(lines[0].coverage, 1.0);
  lines = bound_coverage(runs, {.correlated_readings = 1e-6});
  EXPECT_LT(lines[0].coverage, 0.05);
  runs.groups[1].bias_mm = 2.0;
  runs.samples[0].state = TrackingState::kUncertain;
  lines = bound_coverage(runs, {.correlated_readings = 8.0});
  EXPECT_EQ(lines[0].num_frames, 49) << "neither a biased nor an uncertain frame";
  EXPECT_EQ(lines[2].name, "far");
  EXPECT_EQ(lines[3].name, "far, told to the bound");
  EXPECT_GT(lines[3].median_bound_mm, lines[2].median_bound_mm);
  EXPECT_EQ(lines.back().name, "uncertain frames");
  EXPECT_EQ(lines.back().num_frames, 1);
}

TEST(BoundCalibration, WritesWhatItMeasured) {
  const auto runs = drawn(5);
  const BoundCalibration calibration{.correlated_readings = 8.0};
  const auto lines = bound_coverage(runs, calibration);
  EXPECT_THAT(to_markdown(lines), HasSubstr("| near | 5 | 15 |"));
  const auto json = nlohmann::json::parse(to_json(lines, runs, {}, calibration));
  EXPECT_EQ(json["simulated"], true);
  EXPECT_EQ(json["groups"][1]["frames"], 5);
  EXPECT_EQ(json["calibration"]["correlated_readings"], 8.0);
  EXPECT_THAT(to_csv(runs, calibration), HasSubstr("\"far\",0,0,1000,tracking"));
}

TEST(BoundStudy, SaysWhatIsWrong) {
  const auto body = internal::bumpy_surface(40);
  const auto quiet = [](std::string_view, double) {};
  EXPECT_THAT(run_bound_study({{"", body, "", 0.0}}, {.num_seeds = 0}, quiet).error().message,
              HasSubstr("at least 1"));
  EXPECT_THAT(run_bound_study({{"", body, "path=circle", 0.0}}, {}, quiet).error().message,
              HasSubstr("circle"));
}

/// The calibration as built in, on a body and seeds that it was not fitted on.
TEST(BoundStudy, TheBoundHoldsOnABodyItWasNotFittedOn) {
  const auto runs = run_bound_study({{"bumpy", internal::bumpy_surface(), "path=sway", 0.0}},
                                    {.first_seed = 2000, .num_seeds = 40, .num_frames = 1},
                                    [](std::string_view, double) {});
  ASSERT_TRUE(runs) << runs.error().message;
  const auto lines = bound_coverage(*runs, default_bound_calibration());
  EXPECT_GE(lines[0].num_frames, 35);
  EXPECT_GE(lines[0].coverage, 0.85);
  EXPECT_LT(lines[0].median_bound_mm, 8.0 * lines[0].median_error_mm) << "it must say something";
}

}  // namespace
}  // namespace mor
