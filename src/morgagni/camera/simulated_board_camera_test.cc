// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/simulated_board_camera.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

/// 300 x 200 mm, its left half black.
BoardPicture half_black() {
  BoardPicture picture;
  picture.mm_per_px = 0.5;
  picture.brightness = Image<std::uint8_t>(600, 400, 240);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 300; ++x) picture.brightness(x, y) = 10;
  }
  picture.first_px_mm = {0.25, 0.25};
  return picture;
}

std::unique_ptr<SimulatedBoardCamera> camera_of(const char* options) {
  return SimulatedBoardCamera::create(half_black(), SimulatedBoardOptions::parse(options).value())
      .value();
}

TEST(SimulatedBoardCamera, ShowsTheBoardWhereItSays) {
  const auto camera = camera_of("seed=5,near=600,far=800,blur=0,grain=0");
  const auto frame = camera->frame_at(1, 0);
  const Eigen::Isometry3d color_from_board =
      camera->truth().color_from_depth * camera->depth_from_board(1);
  const auto brightness = [&](double x_mm, double y_mm) {
    const auto px =
        camera->truth().color.project(color_from_board * Eigen::Vector3d(x_mm, y_mm, 0.0));
    return frame
        ->color(static_cast<int>(std::lround(px->x())), static_cast<int>(std::lround(px->y())))
        .r;
  };
  for (const double y_mm : {40.0, 100.0, 160.0}) {
    EXPECT_LT(brightness(145.0, y_mm), 60);
    EXPECT_GT(brightness(155.0, y_mm), 120);
  }
}

TEST(SimulatedBoardCamera, MeasuresItsDepthWithTheBiasItSays) {
  const auto camera = camera_of("seed=5,near=600,far=800,sensor=tof,bias=5,wall=1");
  const auto frame = camera->frame_at(1, 0);
  const Eigen::Isometry3d pose = camera->depth_from_board(1);
  const Eigen::Vector3d normal = pose.linear().col(2);
  double sum_mm = 0.0;
  double bias_sq = 0.0;
  int count = 0;
  for (int y = 10; y < 480; y += 20) {
    for (int x = 10; x < 640; x += 20) {
      const Eigen::Vector3d ray = camera->truth().depth.ray(Eigen::Vector2d(x, y)).homogeneous();
      double z_mm = normal.dot(pose.translation()) / normal.dot(ray);
      const Eigen::Vector3d place = pose.inverse() * (z_mm * ray);
      const bool is_on_board =
          place.x() > 0.0 && place.y() > 0.0 && place.x() < 300.0 && place.y() < 200.0;
      // The wall is behind the board.
      if (!is_on_board) z_mm += 3.0 / normal.dot(ray);
      const double bias_mm = camera->bias_mm(x, y, z_mm);
      sum_mm += std::abs(frame->depth_mm(x, y) - z_mm - bias_mm);
      bias_sq += bias_mm * bias_mm;
      ++count;
    }
  }
  EXPECT_LT(sum_mm / count, 2.0) << "noise";
  EXPECT_GT(std::sqrt(bias_sq / count), 2.0);
}

TEST(SimulatedBoardCamera, HangsTheBoardOnAWallInTurns) {
  const auto camera = camera_of("seed=5,sensor=tof,bias=0");
  const auto farthest_mm = [&](std::uint64_t pose) {
    const auto frame = camera->frame_at(pose, 0);
    return *std::max_element(frame->depth_mm.data(),
                             frame->depth_mm.data() + frame->depth_mm.size());
  };
  EXPECT_GT(farthest_mm(35), 2000);
  EXPECT_LT(farthest_mm(36), 2000);
  EXPECT_LT(farthest_mm(49), 2000);
  EXPECT_GT(farthest_mm(50), 2000);
}

TEST(SimulatedBoardCamera, GivesTheSameFramesForTheSameSeed) {
  const auto one = camera_of("seed=9");
  const auto other = camera_of("seed=9");
  const auto third = camera_of("seed=10");
  EXPECT_EQ(one->frame_at(2, 1)->depth_mm, other->frame_at(2, 1)->depth_mm);
  EXPECT_EQ(one->frame_at(2, 1)->color, other->frame_at(2, 1)->color);
  EXPECT_NE(one->frame_at(2, 1)->depth_mm, one->frame_at(2, 2)->depth_mm);
  EXPECT_NE(one->truth().color.focal_x_px, third->truth().color.focal_x_px);
  EXPECT_EQ(one->calibration(), third->calibration()) << "the design says nothing of the truth";
}

TEST(SimulatedBoardCamera, SaysWhatIsWrongWithItsName) {
  const auto message = [](const char* text) {
    return SimulatedBoardOptions::parse(text).error().message;
  };
  EXPECT_THAT(message("size=3"), HasSubstr("size"));
  EXPECT_THAT(message("near=100"), HasSubstr("near"));
  EXPECT_THAT(message("near=900,far=800"), HasSubstr("far in [near, 3000]"));
  EXPECT_THAT(message("sensor=radar"), HasSubstr("kinect"));
  EXPECT_THAT(SimulatedBoardCamera::create({}, {}).error().message, HasSubstr("no picture"));
}

}  // namespace
}  // namespace mor
