// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/depth_fit.h"

#include <cmath>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/calibration/plane_geometry.h"
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

/// Walls at some distances, seen whole.
std::vector<DepthReading> walls(const std::vector<double>& distances_mm,
                                const Bias& bias,
                                double noise_mm,
                                double width_share = 1.0) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<DepthReading> readings;
  for (std::size_t view = 0; view < distances_mm.size(); ++view) {
    for (int y = 12; y < 480; y += 24) {
      for (int x = 12; x < 640 * width_share; x += 24) {
        // The wall is a little aslant.
        const double z_mm = distances_mm[view] * (1.0 + 0.0001 * (x - 320));
        const double seen_mm =
            z_mm + bias(x / 319.5 - 1.0, y / 239.5 - 1.0, z_mm) + noise_mm * noise(random);
        readings.push_back({static_cast<int>(view), Eigen::Vector2d(x, y), seen_mm, z_mm});
      }
    }
  }
  return readings;
}

/// How much of the bias is left, over the picture and the distances read.
double left_share(const DepthCorrection& correction, const Bias& bias) {
  double before = 0.0;
  double after = 0.0;
  for (double z_mm = 520.0; z_mm < 1200.0; z_mm += 35.0) {
    for (int y = 5; y < 480; y += 17) {
      for (int x = 5; x < 640; x += 17) {
        const double wrong_mm = bias(x / 319.5 - 1.0, y / 239.5 - 1.0, z_mm);
        const double left_mm =
            wrong_mm + correction.add_mm(Eigen::Vector2d(x, y), 640, 480, z_mm + wrong_mm);
        before += wrong_mm * wrong_mm;
        after += left_mm * left_mm;
      }
    }
  }
  return std::sqrt(after / before);
}

const std::vector<double> kDistances = {
    520.0, 570.0, 620.0, 680.0, 740.0, 800.0, 860.0, 930.0, 1000.0, 1070.0, 1140.0, 1215.0};

TEST(DepthFit, TakesOutTheErrorOfStructuredLight) {
  const auto fit = fit_depth(walls(kDistances, kinect_bias, 0.5), 640, 480).value();
  EXPECT_LT(left_share(fit.correction, kinect_bias), 0.2);
  EXPECT_TRUE(fit.helps());
  EXPECT_EQ(fit.num_distances, 12);
  EXPECT_EQ(fit.coverage, 1.0);
  EXPECT_LT(fit.rms_after_mm, 0.2 * fit.rms_before_mm + 0.6);
}

TEST(DepthFit, TakesOutTheErrorOfTimeOfFlight) {
  const auto fit = fit_depth(walls(kDistances, time_of_flight_bias, 0.5), 640, 480).value();
  EXPECT_EQ(fit.form, DepthForm::kTimeOfFlight) << "it was found out by itself";
  EXPECT_LT(left_share(fit.correction, time_of_flight_bias), 0.2);
}

TEST(DepthFit, IsNotMisledByReadingsOfOtherThings) {
  auto readings = walls(kDistances, kinect_bias, 0.5);
  for (std::size_t i = 0; i < readings.size(); i += 9) readings[i].seen_mm -= 25.0;
  const auto fit = fit_depth(readings, 640, 480).value();
  EXPECT_LT(left_share(fit.correction, kinect_bias), 0.25);
}

TEST(DepthFit, SaysThatItDoesNotHelpWhereThereIsNoError) {
  const auto none = [](double, double, double) { return 0.0; };
  const auto fit = fit_depth(walls(kDistances, none, 1.0), 640, 480).value();
  EXPECT_FALSE(fit.helps());
}

TEST(DepthFit, RefusesTooFewDistances) {
  EXPECT_THAT(
      fit_depth(walls({700.0, 705.0, 710.0, 1200.0}, kinect_bias, 0.5), 640, 480).error().message,
      HasSubstr("was seen at 2 distances"));
  EXPECT_THAT(
      fit_depth(walls({700.0, 745.0, 792.0, 842.0}, kinect_bias, 0.5), 640, 480).error().message,
      HasSubstr("the farthest 1.35 times the nearest"));
  EXPECT_THAT(fit_depth({}, 640, 480).error().message, HasSubstr("was seen at 0 distances"));
}

TEST(DepthFit, RefusesTooLittleOfThePicture) {
  EXPECT_THAT(fit_depth(walls(kDistances, kinect_bias, 0.5, 0.3), 640, 480).error().message,
              HasSubstr("% of the depth picture at two distances, at least 50 %"));
}

class PlaneGeometryTest : public testing::Test {
 protected:
  PlaneGeometryTest() {
    design_.depth = {640, 480, 580.0, 580.0, 319.5, 239.5, {}};
    design_.color = internal::sample_lens();
    design_.color_from_depth.translation().x() = -25.0;
    truth_ = design_;
    truth_.depth.focal_x_px *= 1.012;
    truth_.depth.focal_y_px *= 1.012;
    truth_.color_from_depth.translation() += Eigen::Vector3d(2.0, 0.0, -3.0);
    truth_.color_from_depth.rotate(
        Eigen::AngleAxisd(0.008, Eigen::Vector3d(0.6, 0.8, 0.0).normalized()));
  }

  std::vector<PlaneView> planes(const std::vector<Eigen::Isometry3d>& poses) const {
    std::mt19937_64 random(3);
    std::normal_distribution<double> noise(0.0, 0.4);
    std::vector<PlaneView> views;
    for (const auto& color_from_board : poses) {
      PlaneView view{.color_from_board = color_from_board, .readings = {}};
      const Eigen::Isometry3d depth_from_board =
          truth_.color_from_depth.inverse() * color_from_board;
      for (int id = 0; id < board_.num_corners(); ++id) {
        const Eigen::Vector3d place = depth_from_board * board_.corner_mm(id);
        if (const auto px = truth_.depth.project(place)) {
          view.readings.push_back({0, *px, place.z() + noise(random), place.z()});
        }
      }
      views.push_back(std::move(view));
    }
    return views;
  }

  CalibrationBoard board_;
  RgbdCalibration design_;
  RgbdCalibration truth_;
};

TEST_F(PlaneGeometryTest, FindsWhatPlanesTell) {
  const auto found =
      find_plane_geometry(planes(internal::sample_poses(board_, 24)), design_).value();
  EXPECT_NEAR(found.depth.focal_x_px, truth_.depth.focal_x_px, 0.003 * truth_.depth.focal_x_px);
  const Eigen::AngleAxisd turn(found.color_from_depth.linear().transpose() *
                               truth_.color_from_depth.linear());
  EXPECT_LT(turn.angle(), 0.006);
  EXPECT_LT(found.rms_mm, 0.7);
  for (const auto& unknown : found.unknowns) {
    EXPECT_GT(unknown.sd, 0.0) << unknown.name;
    EXPECT_LE(unknown.sd, 1.001 * unknown.sd_before) << unknown.name;
  }
}

TEST_F(PlaneGeometryTest, RefusesTooFewOrParallelPlanes) {
  EXPECT_THAT(
      find_plane_geometry(planes(internal::sample_poses(board_, 5)), design_).error().message,
      HasSubstr("in only 5 views"));
  std::vector<Eigen::Isometry3d> parallel;
  for (int i = 0; i < 10; ++i) {
    parallel.push_back(internal::sample_pose(board_, 0.5, 0.5, 600.0 + 60.0 * i, 0.0, 0.0));
  }
  EXPECT_THAT(find_plane_geometry(planes(parallel), design_).error().message,
              HasSubstr("parallel within"));
}

}  // namespace
}  // namespace mor
