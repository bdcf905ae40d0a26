// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/joint_calibration.h"

#include <cmath>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/calibration/internal/joint_rows.h"
#include "morgagni/calibration/testing/synthetic_views.h"

namespace mor {
namespace {

using testing::HasSubstr;

/// What a sensor adds at a place of the picture, from -1 to 1, and a true distance.
using Bias = std::function<double(double u, double v, double z_mm)>;

double kinect_bias(double u, double v, double z_mm) {
  const double along = z_mm / 800.0;
  return along * (3.0 * u * u - 1.0 + v) + along * along * (1.5 * u - v * v);
}

double time_of_flight_bias(double u, double v, double z_mm) {
  return 2.0 * u + 3.0 * v * v - 4.0 + 2.5 * std::sin(z_mm / 140.0);
}

double no_bias(double /*u*/, double /*v*/, double /*z_mm*/) {
  return 0.0;
}

double bias_at(const Bias& bias, const Eigen::Vector2d& px, double z_mm) {
  return bias(px.x() / 319.5 - 1.0, px.y() / 239.5 - 1.0, z_mm);
}

/// How much of the bias is left, over the picture and the distances read.
double left_share(const DepthCorrection& correction, const Bias& bias) {
  double before = 0.0;
  double after = 0.0;
  for (double z_mm = 600.0; z_mm < 1050.0; z_mm += 35.0) {
    for (int y = 5; y < 480; y += 17) {
      for (int x = 5; x < 640; x += 17) {
        const Eigen::Vector2d px(x, y);
        const double wrong_mm = bias_at(bias, px, z_mm);
        const double left_mm = wrong_mm + correction.add_mm(px, 640, 480, z_mm + wrong_mm);
        before += wrong_mm * wrong_mm;
        after += left_mm * left_mm;
      }
    }
  }
  return std::sqrt(after / before);
}

/// A device that is not as designed, and a session with it: boards in the air, then on a wall.
class JointCalibrationTest : public testing::Test {
 protected:
  static constexpr double kWallBehindMm = 4.0;
  static constexpr int kNumInAir = 18;
  static constexpr int kNumOnWall = 9;

  JointCalibrationTest() {
    design_.depth = {640, 480, 580.0, 580.0, 319.5, 239.5, {}};
    design_.color = internal::sample_lens();
    design_.color_from_depth.translation().x() = -25.0;
    truth_ = design_;
    truth_.depth = {640, 480, 586.0, 585.2, 323.0, 236.0, {-0.06, 0.05, 0.0005, -0.0004, 0.0}};
    truth_.color_from_depth.translation() += Eigen::Vector3d(1.5, 0.4, -1.0);
    truth_.color_from_depth.rotate(
        Eigen::AngleAxisd(0.008, Eigen::Vector3d(0.6, 0.8, 0.0).normalized()));
  }

  /// @param reaches_beside  The wall that the board lies on is read too.
  std::vector<DepthReading> readings(const Eigen::Isometry3d& depth_from_board,
                                     const Bias& bias,
                                     bool reaches_beside,
                                     std::mt19937_64& random) const {
    std::normal_distribution<double> noise(0.0, 0.2);
    const Eigen::Isometry3d board_from_depth = depth_from_board.inverse();
    const Eigen::Vector3d last = board_.corner_mm(board_.num_corners() - 1);
    std::vector<DepthReading> readings;
    for (int y = 8; y < 480; y += 16) {
      for (int x = 8; x < 640; x += 16) {
        const Eigen::Vector2d px(x, y);
        const Eigen::Vector2d ray = truth_.depth.ray(px);
        const Eigen::Vector3d normal = depth_from_board.linear().col(2);
        Eigen::Vector3d on_plane = depth_from_board.translation();
        double z_mm = internal::meet(ray, normal, on_plane).z_mm;
        const Eigen::Vector3d place = board_from_depth * (z_mm * ray.homogeneous());
        const bool is_on_board = (place.head<2>().array() >= 0.0).all() &&
                                 (place.head<2>().array() <= last.head<2>().array()).all();
        if (!is_on_board && !reaches_beside) continue;
        if (!is_on_board) {
          on_plane += kWallBehindMm * normal;
          z_mm = internal::meet(ray, normal, on_plane).z_mm;
        }
        readings.push_back({.px = px,
                            .seen_mm = z_mm + bias_at(bias, px, z_mm) + noise(random),
                            .true_mm = z_mm,
                            .is_beside = !is_on_board});
      }
    }
    return readings;
  }

  std::vector<JointView> session(const Bias& bias) const {
    std::mt19937_64 random(7);
    std::vector<JointView> views;
    auto poses = internal::sample_poses(board_, kNumInAir);
    for (int i = 0; i < kNumOnWall; ++i) {
      poses.push_back(internal::sample_pose(
          board_, 0.4 + 0.1 * (i % 3), 0.5, 560.0 + 70.0 * i, 5.0 * (i % 3), 6.0 - 3.0 * (i % 5)));
    }
    for (const auto& color_from_board : poses) {
      const bool is_on_wall = views.size() >= kNumInAir;
      const Eigen::Isometry3d depth_from_board =
          truth_.color_from_depth.inverse() * color_from_board;
      JointView view{
          .color = internal::sighting_at(board_, truth_.color, color_from_board, 0.05, random)};
      view.infrared = internal::sighting_at(board_, truth_.depth, depth_from_board, 0.1, random);
      view.readings = readings(depth_from_board, bias, is_on_wall, random);
      view.depth_from_board = design_.color_from_depth.inverse() * color_from_board;
      views.push_back(std::move(view));
    }
    return views;
  }

  void expect_found(const JointCalibration& found, double slack) const {
    EXPECT_NEAR(found.depth.focal_x_px / truth_.depth.focal_x_px, 1.0, 0.001 * slack);
    EXPECT_NEAR(found.depth.focal_y_px / truth_.depth.focal_y_px, 1.0, 0.001 * slack);
    EXPECT_NEAR(found.depth.center_x_px, truth_.depth.center_x_px, 0.6 * slack);
    EXPECT_NEAR(found.depth.center_y_px, truth_.depth.center_y_px, 0.6 * slack);
    EXPECT_LT((found.color_from_depth.translation() - truth_.color_from_depth.translation()).norm(),
              0.5 * slack);
    EXPECT_NEAR(found.wall_behind_mm, kWallBehindMm, 0.3);
  }

  CalibrationBoard board_;
  RgbdCalibration design_;
  RgbdCalibration truth_;
};

TEST_F(JointCalibrationTest, FindsAllOfAStructuredLightCamera) {
  const auto found = calibrate_jointly(board_, session(kinect_bias), design_, {});
  expect_found(found, 1.0);
  EXPECT_LT(left_share(found.correction, kinect_bias), 0.12);
  EXPECT_NEAR(found.color_rms_px, 0.05 * std::sqrt(2.0), 0.01);
  EXPECT_NEAR(found.infrared_rms_px, 0.1 * std::sqrt(2.0), 0.02);
  EXPECT_LT(found.depth_sd.focal_x_px, 0.001 * truth_.depth.focal_x_px);
  EXPECT_GT(found.depth_sd.focal_x_px, 0.00002 * truth_.depth.focal_x_px);
}

TEST_F(JointCalibrationTest, FindsAllOfATimeOfFlightCamera) {
  const auto found = calibrate_jointly(
      board_, session(time_of_flight_bias), design_, {.form = DepthForm::kTimeOfFlight});
  expect_found(found, 1.0);
  EXPECT_LT(left_share(found.correction, time_of_flight_bias), 0.15);
}

TEST_F(JointCalibrationTest, IsNotMisledByReadingsOfOtherThings) {
  auto views = session(kinect_bias);
  for (auto& view : views) {
    for (std::size_t i = 0; i < view.readings.size(); i += 9) view.readings[i].seen_mm -= 25.0;
  }
  const auto found = calibrate_jointly(board_, views, design_, {});
  expect_found(found, 1.0);
  EXPECT_LT(left_share(found.correction, kinect_bias), 0.12);
}

TEST_F(JointCalibrationTest, FindsTheDepthCameraWithoutInfraredByItsPlanes) {
  auto views = session(kinect_bias);
  for (auto& view : views) view.infrared.reset();
  const auto found = calibrate_jointly(board_, views, design_, {.design_trust = DesignTrust{}});
  expect_found(found, 4.0);
  EXPECT_LT(left_share(found.correction, kinect_bias), 0.4);
  EXPECT_LT(found.depth_sd.focal_x_px, 0.002 * truth_.depth.focal_x_px);
}

TEST_F(JointCalibrationTest, ReadsAnInfraredPictureThatIsCutElsewhere) {
  const Eigen::Vector2d offset_px(-5.0, -4.0);
  auto views = session(kinect_bias);
  for (auto& view : views) {
    for (auto& corner : view.infrared->corners) corner.px -= offset_px;
  }
  const auto found = calibrate_jointly(board_, views, design_, {.infrared_offset_px = offset_px});
  EXPECT_NEAR(found.depth.center_x_px, truth_.depth.center_x_px + 5.0, 0.6);
  EXPECT_NEAR(found.depth.center_y_px, truth_.depth.center_y_px + 4.0, 0.6);
  EXPECT_LT(left_share(found.correction, kinect_bias), 0.12);
}

TEST_F(JointCalibrationTest, SaysWhatReadingsAreOff) {
  auto views = session(kinect_bias);
  const auto last = views.back().readings;
  views.back().readings.clear();
  const auto found = calibrate_jointly(board_, views, design_, {});
  const auto errors =
      reading_errors(board_, found, views.size() - 1, last, Eigen::Vector2d::Zero());
  EXPECT_LT(errors.rms_after_mm, 0.6);
  EXPECT_GT(errors.rms_before_mm, 3.0 * errors.rms_after_mm);

  const auto right = session(no_bias);
  const auto none = calibrate_jointly(board_, right, design_, {});
  EXPECT_LT(
      reading_errors(board_, none, 3, right[3].readings, Eigen::Vector2d::Zero()).rms_before_mm,
      0.4);
}

TEST(JointRows, SlopesAreThoseOfSmallSteps) {
  const PinholeCamera lens{640, 480, 586.0, 583.0, 323.0, 236.0, {-0.1, 0.08, 0.001, -0.002, 0.0}};
  const Eigen::Vector3d point(210.0, -150.0, 800.0);
  const auto seen = internal::see(lens, point).value();
  EXPECT_TRUE(seen.px.isApprox(lens.project(point).value(), 1e-12));
  const auto ray = internal::ray_of(lens, seen.px);
  const Eigen::Vector3d normal(0.2, -0.3, 0.93);
  const Eigen::Vector3d on_plane(20.0, 30.0, 820.0);
  const auto met = internal::meet(ray.ray, normal, on_plane);
  for (int i = 0; i < internal::kLensSize; ++i) {
    PinholeCamera beside = lens;
    internal::LensVector values = internal::lens_vector(lens);
    const double step = i < 4 ? 1e-3 : 1e-6;
    values[i] += step;
    internal::set_lens(values, beside);
    const Eigen::Vector2d moved_px = (*beside.project(point) - seen.px) / step;
    EXPECT_LT((moved_px - seen.by_lens.col(i)).norm(), 1e-3 * (1.0 + moved_px.norm())) << i;
    const Eigen::Vector2d moved_ray = (beside.ray(seen.px) - ray.ray) / step;
    EXPECT_LT((moved_ray - ray.by_lens.col(i)).norm(), 1e-3 * (1e-3 + moved_ray.norm())) << i;
  }
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d moved_px = (*lens.project(point + axis) - seen.px);
    EXPECT_LT((moved_px - seen.by_point.col(i)).norm(), 5e-3) << i;
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(kStep, axis).toRotationMatrix();
    const double by_turn =
        (internal::meet(ray.ray, turned * normal, on_plane).z_mm - met.z_mm) / kStep;
    EXPECT_NEAR(by_turn, met.by_turn[i], 1e-2) << i;
    const double by_normal =
        (internal::meet(ray.ray, normal + kStep * axis, on_plane).z_mm - met.z_mm) / kStep;
    EXPECT_NEAR(by_normal, met.by_normal[i], 1e-1) << i;
    const double by_shift =
        (internal::meet(ray.ray, normal, on_plane + kStep * axis).z_mm - met.z_mm) / kStep;
    EXPECT_NEAR(by_shift, met.by_shift[i], 1e-4) << i;
  }
}

/// Readings over a share of the picture's width at some distances.
std::vector<DepthReading> read_at(const std::vector<double>& distances_mm, double width_share) {
  std::vector<DepthReading> readings;
  for (std::size_t view = 0; view < distances_mm.size(); ++view) {
    for (int y = 12; y < 480; y += 24) {
      for (int x = 12; x < 640 * width_share; x += 24) {
        readings.push_back({.view = static_cast<int>(view),
                            .px = Eigen::Vector2d(x, y),
                            .seen_mm = distances_mm[view],
                            .true_mm = distances_mm[view]});
      }
    }
  }
  return readings;
}

TEST(DepthSpan, CountsDistancesAndCoverage) {
  const auto span = depth_span(read_at({520.0, 600.0, 605.0, 700.0, 1000.0}, 0.75), 640, 480);
  ASSERT_TRUE(span);
  EXPECT_EQ(span->num_distances, 4);
  EXPECT_NEAR(span->coverage, 0.75, 0.01);
}

TEST(DepthSpan, RefusesTooFewDistances) {
  EXPECT_THAT(depth_span(read_at({700.0, 705.0, 710.0, 1200.0}, 1.0), 640, 480).error().message,
              HasSubstr("was seen at 2 distances"));
  EXPECT_THAT(depth_span(read_at({700.0, 745.0, 792.0, 842.0}, 1.0), 640, 480).error().message,
              HasSubstr("the farthest 1.35 times the nearest"));
  EXPECT_THAT(depth_span({}, 640, 480).error().message, HasSubstr("was seen at 0 distances"));
}

TEST(DepthSpan, RefusesTooLittleOfThePicture) {
  EXPECT_THAT(depth_span(read_at({520.0, 600.0, 700.0, 1000.0}, 0.3), 640, 480).error().message,
              HasSubstr("% of the depth picture at two distances, at least 50 %"));
}

}  // namespace
}  // namespace mor
