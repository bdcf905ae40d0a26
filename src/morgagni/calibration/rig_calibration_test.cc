// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// From drawn pictures of a board to a calibration: the whole way, with noise, once. How near it
// comes over many cameras, benchmarks/accuracy/calibration_accuracy measures.
#include "morgagni/calibration/rig_calibration.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/calibration/board_pattern.h"
#include "morgagni/calibration/calibration_check.h"
#include "morgagni/calibration/view_collector.h"
#include "morgagni/calibration/view_source.h"

namespace mor {
namespace {

using testing::HasSubstr;

/// Drawn once for all tests: views in the air, then on a wall.
struct Drawn {
  CalibrationBoard board;
  std::unique_ptr<SimulatedBoardCamera> camera;
  std::unique_ptr<SimulatedBoardCamera> wall;
  std::vector<RigView> views;

  static const Drawn& get() {
    static const Drawn kDrawn;
    return kDrawn;
  }

 private:
  Drawn() {
    const auto camera_of = [&](const char* options) {
      return SimulatedBoardCamera::create(board_picture(board),
                                          SimulatedBoardOptions::parse(options).value())
          .value();
    };
    camera = camera_of("seed=17,near=450,far=1200,wall=0");
    wall = camera_of("seed=17,near=500,far=1250,tilt=15,wall=1");
    ViewCollector collector(board, camera->calibration());
    const auto add = [&](const SimulatedBoardCamera& from, std::uint64_t count) {
      for (std::uint64_t pose = 0; pose < count; ++pose) {
        const auto frame = from.frame_at(pose, 0);
        const auto infrared = from.infrared_at(pose);
        (void)collector.add("", &frame->color, &infrared, &frame->depth_mm);
      }
    };
    add(*camera, 16);
    add(*wall, 8);
    views = collector.views();
  }
};

TEST(RigCalibration, FindsLensesPlaceAndDepthErrorFromPictures) {
  const auto& drawn = Drawn::get();
  const auto result = calibrate_rig(drawn.board, drawn.views, drawn.camera->calibration()).value();
  const auto& found = result.calibration;
  const auto& truth = drawn.camera->truth();
  EXPECT_NEAR(found.color.focal_x_px / truth.color.focal_x_px, 1.0, 0.001);
  EXPECT_NEAR(found.depth.focal_x_px / truth.depth.focal_x_px, 1.0, 0.001);
  EXPECT_NEAR(found.color.center_x_px, truth.color.center_x_px, 0.8);
  EXPECT_NEAR(found.depth.center_y_px, truth.depth.center_y_px, 0.8);
  EXPECT_NEAR(found.color_from_depth.translation().norm(),
              truth.color_from_depth.translation().norm(),
              0.3);
  // What it says of its own exactness holds, and is no boast.
  ASSERT_TRUE(found.depth_sd);
  EXPECT_LT(std::abs(found.depth.focal_x_px / truth.depth.focal_x_px - 1.0),
            3.0 * found.depth_sd->focal_ratio);
  EXPECT_LT(std::abs(found.depth.center_x_px - truth.depth.center_x_px),
            3.0 * found.depth_sd->center_px);
  EXPECT_LE(found.depth_sd->focal_ratio, 0.0015);
  EXPECT_GE(found.depth_sd->focal_ratio, 0.001);
  ASSERT_TRUE(found.depth_correction);
  double before = 0.0;
  double after = 0.0;
  for (double z_mm = 550.0; z_mm < 1150.0; z_mm += 50.0) {
    for (int y = 20; y < 480; y += 40) {
      for (int x = 20; x < 640; x += 40) {
        const double wrong_mm = drawn.camera->bias_mm(x, y, z_mm);
        const double left_mm = wrong_mm + found.depth_correction->add_mm(
                                              Eigen::Vector2d(x, y), 640, 480, z_mm + wrong_mm);
        before += wrong_mm * wrong_mm;
        after += left_mm * left_mm;
      }
    }
  }
  EXPECT_LT(std::sqrt(after / before), 0.2);
  EXPECT_EQ(result.depth->form, DepthForm::kDisparity) << "it was found out by itself";
  EXPECT_TRUE(result.depth->helps());
  EXPECT_FALSE(result.figures().empty());

  // The check sees the difference.
  const std::vector<RigView> few(drawn.views.end() - 4, drawn.views.end());
  const auto with = check_calibration(drawn.board, few, found).value();
  const auto without = check_calibration(drawn.board, few, drawn.camera->calibration()).value();
  EXPECT_LT(with.depth_error_rms_mm, 2.5);
  EXPECT_LT(with.size_error_mm, 2.5);
  EXPECT_LT(with.reprojection_px, 0.4);
  EXPECT_GT(without.depth_error_rms_mm, 2.0 * with.depth_error_rms_mm);
  EXPECT_THAT(without.verdict(), HasSubstr("again"));
}

TEST(RigCalibration, FindsTheDepthCameraByPlanesAlone) {
  const auto& drawn = Drawn::get();
  auto views = drawn.views;
  for (auto& view : views) view.infrared.reset();
  const auto result = calibrate_rig(drawn.board, views, drawn.camera->calibration()).value();
  EXPECT_FALSE(result.stereo);
  EXPECT_THAT(result.remarks, testing::Contains(HasSubstr("by the board's planes alone")));
  ASSERT_EQ(result.changes.size(), 11U);
  for (const auto& change : result.changes) {
    EXPECT_GT(change.sd, 0.0) << change.name;
    EXPECT_LE(change.sd, 1.001 * change.sd_before) << change.name;
  }
  const auto& truth = drawn.camera->truth();
  EXPECT_NEAR(result.calibration.depth.focal_x_px / truth.depth.focal_x_px, 1.0, 0.004);
  EXPECT_TRUE(result.calibration.depth_correction);
}

TEST(RigCalibration, TellsAWrongSquareSizeByTheDepth) {
  const auto& drawn = Drawn::get();
  CalibrationBoard wrong = drawn.board;
  wrong.square_mm *= 1.1;
  wrong.marker_mm *= 1.1;
  const auto refused = calibrate_rig(wrong, drawn.views, drawn.camera->calibration());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("squares are 3"));
  EXPECT_THAT(refused.error().message, HasSubstr("mm wide, not 40.7"));
}

TEST(RigCalibration, RefusesAColourAndAnInfraredThatMovedApart) {
  const auto& drawn = Drawn::get();
  auto views = drawn.views;
  for (std::size_t i = 0; i + 1 < views.size(); i += 2) {
    std::swap(views[i].infrared, views[i + 1].infrared);
  }
  const auto refused = calibrate_rig(drawn.board, views, drawn.camera->calibration());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("did the board move between the two?"));
}

TEST(ViewCollector, TakesEachStillPoseOnce) {
  const auto& drawn = Drawn::get();
  ViewCollector collector(drawn.board, drawn.camera->calibration(), {.still_frames = 3});
  int num_taken = 0;
  for (std::uint64_t pose : {4U, 0U}) {
    for (std::uint64_t repeat = 0; repeat < 5; ++repeat) {
      const auto look = collector.look(*drawn.camera->frame_at(pose, repeat));
      num_taken += look.was_taken ? 1 : 0;
      if (repeat == 0) {
        EXPECT_EQ(look.say, "hold still");
      }
      if (repeat == 4) {
        EXPECT_THAT(look.say, HasSubstr("this pose is taken"));
      }
    }
  }
  EXPECT_EQ(num_taken, 2);
  EXPECT_EQ(collector.coverage().num_views, 2);
  EXPECT_FALSE(collector.views()[0].depth_mm.empty());
  collector.drop_last();
  EXPECT_EQ(collector.views().size(), 1U);
  RgbdFrame nothing;
  nothing.color = Image<Rgb8>(640, 480);
  nothing.depth_mm = Image<std::uint16_t>(640, 480);
  EXPECT_THAT(collector.look(nothing).say, HasSubstr("no board"));
}

TEST(ViewSource, RefusesAFolderWithoutPictures) {
  EXPECT_THAT(read_still_pictures("/nowhere/at/all").error().message, HasSubstr("no such folder"));
  EXPECT_THAT(open_camera_before_board("simulated:", {}).error().message,
              HasSubstr("holds no board"));
  EXPECT_THAT(open_camera_before_board("simulated-board:size=3", {}).error().message,
              HasSubstr("size"));
}

}  // namespace
}  // namespace mor
