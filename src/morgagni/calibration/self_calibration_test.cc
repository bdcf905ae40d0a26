// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/self_calibration.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

const PinholeCamera kCamera{.width_px = 640,
                            .height_px = 480,
                            .focal_x_px = 525.0,
                            .focal_y_px = 525.0,
                            .center_x_px = 319.5,
                            .center_y_px = 239.5};

const RgbdCalibration kCalibration{.depth = kCamera, .color = kCamera};

TriangleMesh bumpy_body() {
  return internal::bumpy_body(60, Eigen::Vector3f::Zero());
}

/// Near and far, from the sides, rolled.
Eigen::Isometry3d body_from_camera(int view) {
  const double t = 0.35 * view;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.rotate(Eigen::AngleAxisd(0.4 * std::sin(t), Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(0.3 * std::sin(1.3 * t), Eigen::Vector3d::UnitX()));
  pose.translate(Eigen::Vector3d(
      40.0 * std::sin(1.7 * t), 30.0 * std::cos(1.1 * t), -680.0 - 220.0 * std::sin(0.7 * t)));
  pose.rotate(Eigen::AngleAxisd(0.5 * std::sin(0.9 * t), Eigen::Vector3d::UnitZ()));
  return pose;
}

/// At 800 mm 6 mm too far at the right edge, 6 mm too near at the left, a bowl on top.
double bias_at_800_mm(int x, int y) {
  const double u = 2.0 * x / (kCamera.width_px - 1) - 1.0;
  const double v = 2.0 * y / (kCamera.height_px - 1) - 1.0;
  return 6.0 * u + 8.0 * (u * u + v * v) - 4.0;
}

/// In proportion to the distance.
double bias_mm(int x, int y, double z_mm) {
  return bias_at_800_mm(x, y) * z_mm / 800.0;
}

/// The same at each.
double fixed_bias_mm(int x, int y, double /*z_mm*/) {
  return bias_at_800_mm(x, y);
}

/// Standard deviation.
double spread_mm(const std::vector<double>& values_mm) {
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values_mm) {
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(values_mm.size());
  return std::sqrt(squares / count - (sum / count) * (sum / count));
}

constexpr double kTableMm = 155.0;  ///< Behind the body's middle.

double level_table(double /*x*/, double /*y*/) {
  return 0.0;
}

/// Up to 2 mm up and down, as no table is that was made for it.
double uneven_table(double x, double y) {
  return 1.2 * std::sin(x / 90.0 + 0.4) + 0.8 * std::cos(y / 130.0);
}

double depth_of_table(double (*height_mm)(double x, double y),
                      const Eigen::Isometry3d& body_from_depth,
                      int x,
                      int y) {
  const Eigen::Vector2d ray = kCamera.ray(Eigen::Vector2d(x, y));
  const Eigen::Vector3d eye = body_from_depth.translation();
  const Eigen::Vector3d direction =
      body_from_depth.linear() * Eigen::Vector3d(ray.x(), ray.y(), 1.0);
  const double level_mm = (kTableMm - eye.z()) / direction.z();
  const Eigen::Vector3d at = eye + level_mm * direction;
  return level_mm - height_mm(at.x(), at.y()) / direction.z();
}

/// Views of a sensor that strays sideways as expected_depth() has it, with noise of 1 mm, at poses
/// off by up to 1 mm and 0.2 degrees.
/// @param share  Of `error_mm`. @param table_mm  Height of a table over (x, y) that lies under the
/// body, in front of which the camera sees the body. Null: none.
std::vector<SensedSkin> views_of(const TriangleMesh& body,
                                 double share,
                                 double (*table_mm)(double x, double y) = nullptr,
                                 double (*error_mm)(int x, int y, double z_mm) = bias_mm) {
  std::mt19937_64 random(7);
  const auto uniform = [&random] {
    return static_cast<double>(random() >> 11U) * 0x1.0p-53 * 2.0 - 1.0;
  };
  std::vector<SensedSkin> views;
  for (int i = 0; i < 48; ++i) {
    const Eigen::Isometry3d truth = body_from_camera(i);
    const auto drawn = expected_depth(body, kCamera, truth);
    Image<std::uint16_t> depth_mm(kCamera.width_px, kCamera.height_px, 0);
    for (int y = 0; y < kCamera.height_px; ++y) {
      for (int x = 0; x < kCamera.width_px; ++x) {
        double z_mm = static_cast<double>(drawn(x, y));
        if (z_mm <= 0.0 && table_mm != nullptr) z_mm = depth_of_table(table_mm, truth, x, y);
        if (z_mm <= 0.0) continue;
        const double noise_mm = uniform() + uniform() + uniform();
        depth_mm(x, y) =
            static_cast<std::uint16_t>(std::lround(z_mm + noise_mm + share * error_mm(x, y, z_mm)));
      }
    }
    const Eigen::Isometry3d tracked =
        truth * Eigen::Translation3d(uniform(), uniform(), uniform()) *
        Eigen::AngleAxisd(0.2 * kDegree * uniform(), Eigen::Vector3d::UnitZ());
    views.push_back(read_skin(body, kCamera, depth_mm.view(), DepthLevels(), tracked));
  }
  return views;
}

TEST(SelfCalibration, FindsASmoothErrorAndProposesToRemoveIt) {
  const auto body = bumpy_body();
  const auto found = estimate_self_calibration(body, kCalibration, views_of(body, 1.0));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(to_string(found->verdict), "error");
  EXPECT_GT(found->held_out.sensor.significance, 3.0);
  EXPECT_LT(found->held_out.sensor_mm, found->held_out.as_it_is_mm);
  // Where the body was seen the shape is right; its mean looks like a shorter way to the body, and
  // is held by the prior.
  std::vector<double> before_mm;
  std::vector<double> after_mm;
  for (int y = 160; y < 320; y += 16) {
    for (int x = 200; x < 440; x += 16) {
      const double bias = bias_mm(x, y, 680.0);
      before_mm.push_back(bias);
      after_mm.push_back(bias + found->correction.add_mm(Eigen::Vector2d(x, y), 640, 480, 680.0));
    }
  }
  EXPECT_LT(spread_mm(after_mm), 0.5 * spread_mm(before_mm));
}

TEST(SelfCalibration, LeavesAnErrorThatHardlyMovesTheBody) {
  const auto body = bumpy_body();
  const auto found = estimate_self_calibration(body, kCalibration, views_of(body, 0.5));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(to_string(found->verdict), "small");
  EXPECT_GT(found->held_out.sensor.significance, 3.0);
  EXPECT_LT(found->shift_mm, 1.0);
}

/// What is left of bias_mm() where the body never was, less the constant.
double left_at_rim_mm(const SelfCalibration& found, double share) {
  std::vector<double> left_mm;
  for (int x = 20; x < 640; x += 30) {
    for (const int y : {30, 450}) {
      left_mm.push_back(share * bias_mm(x, y, 800.0) +
                        found.correction.add_mm(Eigen::Vector2d(x, y), 640, 480, 800.0));
    }
  }
  return spread_mm(left_mm);
}

TEST(SelfCalibration, ATableUnderTheBodyTellsMoreThanTheBodyAlone) {
  const auto body = bumpy_body();
  const auto alone = estimate_self_calibration(body, kCalibration, views_of(body, 1.0));
  const auto with_table =
      estimate_self_calibration(body, kCalibration, views_of(body, 1.0, uneven_table));
  ASSERT_TRUE(alone && with_table);
  EXPECT_FALSE(alone->sees_table);
  EXPECT_TRUE(with_table->sees_table);
  EXPECT_EQ(to_string(with_table->verdict), "error");
  EXPECT_GT(with_table->held_out.sensor.share, 2.0 * alone->held_out.sensor.share);
  EXPECT_LT(with_table->open_share, alone->open_share);
  EXPECT_LT(left_at_rim_mm(*with_table, 1.0), 0.5 * left_at_rim_mm(*alone, 1.0));
}

/// How uneven the correction is over the picture's middle at a distance, standard deviation.
double unevenness_mm(const SelfCalibration& found, double z_mm) {
  std::vector<double> add_mm;
  for (int y = 120; y < 360; y += 16) {
    for (int x = 160; x < 480; x += 16) {
      add_mm.push_back(found.correction.add_mm(Eigen::Vector2d(x, y), 640, 480, z_mm));
    }
  }
  return spread_mm(add_mm);
}

TEST(SelfCalibration, TellsHowTheErrorGoesWithTheDistance) {
  const auto body = bumpy_body();
  const auto growth = [&](double (*error_mm)(int x, int y, double z_mm)) {
    const auto found =
        estimate_self_calibration(body, kCalibration, views_of(body, 1.0, uneven_table, error_mm));
    return unevenness_mm(*found, 900.0) / unevenness_mm(*found, 600.0);
  };
  EXPECT_NEAR(growth(bias_mm), 1.5, 0.1);
  EXPECT_NEAR(growth(fixed_bias_mm), 1.0, 0.1);
}

TEST(SelfCalibration, AKnownPinholeLeavesLessUnknown) {
  const auto body = bumpy_body();
  const auto views = views_of(body, 1.0, uneven_table, fixed_bias_mm);
  auto calibrated = kCalibration;
  calibrated.depth_sd = PinholeSd{.focal_ratio = 0.001, .center_px = 0.2};
  const auto by_design = estimate_self_calibration(body, kCalibration, views);
  const auto known = estimate_self_calibration(body, calibrated, views);
  ASSERT_TRUE(by_design && known);
  EXPECT_LT(known->remaining_mm, 0.9 * by_design->remaining_mm);
  EXPECT_LT(std::abs(known->focal_x_ratio), 0.003);
  EXPECT_LT(known->center_px.norm(), 0.6);
}

TEST(SelfCalibration, ATablesUnevennessIsNoErrorOfTheSensor) {
  const auto body = bumpy_body();
  for (const auto table : {level_table, uneven_table}) {
    const auto found = estimate_self_calibration(body, kCalibration, views_of(body, 0.0, table));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_TRUE(found->sees_table);
    EXPECT_FALSE(found->proposes()) << found->held_out.sensor.share;
    EXPECT_LT(found->shift_mm, 1.0);
  }
}

TEST(SelfCalibration, LeavesASensorWithoutErrorAsItIs) {
  const auto body = bumpy_body();
  const auto found = estimate_self_calibration(body, kCalibration, views_of(body, 0.0));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NE(to_string(found->verdict), "error");
  EXPECT_LT(found->shift_mm, 1.5);
  EXPECT_FALSE(found->proposes());
}

/// The body some time after its CT: its skin has moved by up to 1.5 mm, in and out.
double change_mm(const Eigen::Vector3f& place) {
  return 1.5 * std::sin(static_cast<double>(place.y()) / 30.0) *
         std::cos(static_cast<double>(place.x()) / 45.0);
}

TriangleMesh changed_body() {
  TriangleMesh body = bumpy_body();
  for (std::size_t i = 0; i < body.vertices.size(); ++i) {
    body.vertices[i] += static_cast<float>(change_mm(body.vertices[i])) * body.normals[i];
  }
  return body;
}

TEST(SelfCalibration, FindsTheSensorsErrorOnAChangedBodyToo) {
  const auto found =
      estimate_self_calibration(bumpy_body(), kCalibration, views_of(changed_body(), 1.5));
  ASSERT_TRUE(found) << found.error().message;
  const auto& held = found->held_out;
  EXPECT_EQ(to_string(found->verdict), "error")
      << held.skin_mm << " to " << held.both_mm << " mm, " << held.sensor.num_better << " parts, "
      << held.sensor.significance;
  EXPECT_GT(found->skin_rms_mm, 0.3) << "else the body had not changed";
}

TEST(SelfCalibration, AChangedBodyAloneIsNoErrorOfTheSensor) {
  const auto body = bumpy_body();
  const auto found = estimate_self_calibration(body, kCalibration, views_of(changed_body(), 0.0));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(to_string(found->verdict), "skin-changed") << found->held_out.skin.share;
  EXPECT_TRUE(found->follows_skin);
  EXPECT_GT(found->skin_most_mm, found->skin_rms_mm);
  // Seen from the front, the change is found but for what a pose is, too.
  const auto now = found->skin.applied_to(body);
  std::vector<double> before_mm;
  std::vector<double> after_mm;
  for (std::size_t i = 0; i < body.vertices.size(); ++i) {
    if (body.normals[i].z() > -0.8F) continue;
    const auto out_mm = (now.vertices[i] - body.vertices[i]).dot(body.normals[i]);
    before_mm.push_back(change_mm(body.vertices[i]));
    after_mm.push_back(change_mm(body.vertices[i]) - static_cast<double>(out_mm));
  }
  ASSERT_GT(before_mm.size(), 50U);
  EXPECT_GT(spread_mm(before_mm), 0.4);
  EXPECT_LT(spread_mm(after_mm), 0.5 * spread_mm(before_mm));
}

TEST(SelfCalibration, SaysWhenThereIsTooLittle) {
  const auto body = bumpy_body();
  auto views = views_of(body, 1.0);
  views.resize(19);
  const auto found = estimate_self_calibration(body, kCalibration, views);
  ASSERT_TRUE(found);
  EXPECT_EQ(to_string(found->verdict), "too-few-views");
}

TEST(SelfCalibration, RefusesBadOptionsAndPoses) {
  const auto body = bumpy_body();
  const auto options = estimate_self_calibration(body, kCalibration, {}, {.columns = 2});
  ASSERT_FALSE(options);
  EXPECT_EQ(options.error().message, "columns must be in [3, 40], got 2");
  std::vector<SensedSkin> views(1);
  views[0].ct_from_depth.translation().x() = std::nan("");
  const auto pose = estimate_self_calibration(body, kCalibration, views);
  ASSERT_FALSE(pose);
  EXPECT_EQ(pose.error().message, "view 0 has a pose that is not finite");
}

}  // namespace
}  // namespace mor
