// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/lens_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/calibration/coverage.h"
#include "morgagni/calibration/testing/synthetic_views.h"

namespace mor {
namespace {

using internal::sample_lens;
using internal::sample_pose;
using internal::sample_poses;
using internal::sample_views;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNoisePx = 0.08;

class LensCalibrationTest : public testing::Test {
 protected:
  Result<LensCalibration> calibrate(const std::vector<LensView>& views) const {
    return calibrate_lens(board_, views, 640, 480);
  }
  std::string refusal(const std::vector<LensView>& views) const {
    const auto lens = calibrate(views);
    return lens ? std::string() : lens.error().message;
  }

  CalibrationBoard board_;
};

TEST_F(LensCalibrationTest, FindsTheLensAndSaysHowWell) {
  const auto poses = sample_poses(board_, 18);
  const auto lens = calibrate(sample_views(board_, poses, kNoisePx, 1)).value();
  const auto truth = sample_lens();
  EXPECT_NEAR(lens.camera.focal_x_px, truth.focal_x_px, 0.002 * truth.focal_x_px);
  EXPECT_NEAR(lens.camera.focal_y_px, truth.focal_y_px, 0.002 * truth.focal_y_px);
  EXPECT_NEAR(lens.camera.center_x_px, truth.center_x_px, 1.0);
  EXPECT_NEAR(lens.camera.center_y_px, truth.center_y_px, 1.0);
  // Where it is, within four of the standard deviations it says, and these are no excuse.
  EXPECT_LT(std::abs(lens.camera.focal_x_px - truth.focal_x_px), 4.0 * lens.sd.focal_x_px);
  EXPECT_LT(lens.sd.focal_x_px, 1.0);
  EXPECT_NEAR(lens.rms_px, kNoisePx * std::sqrt(2.0), 0.02);
  EXPECT_NEAR(lens.held_out_rms_px, kNoisePx * std::sqrt(2.0), 0.05);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_TRUE(lens.views[i].is_used);
    EXPECT_LT((lens.camera_from_board[i]->translation() - poses[i].translation()).norm(), 3.0);
  }
}

TEST_F(LensCalibrationTest, RefusesTooFewViews) {
  const auto views = sample_views(board_, sample_poses(board_, 7), kNoisePx, 2);
  EXPECT_THAT(refusal(views), HasSubstr("only 7 views show the board well, at least 8"));
  EXPECT_THAT(refusal({}), HasSubstr("only 0 views"));
}

TEST_F(LensCalibrationTest, RefusesBlurredViews) {
  auto views = sample_views(board_, sample_poses(board_, 12), kNoisePx, 3);
  for (std::size_t i = 0; i < 6; ++i) views[i].sighting.edge_width_px = 6.0;
  EXPECT_THAT(refusal(views), HasSubstr("only 6 views show the board well (6 are blurred"));
}

TEST_F(LensCalibrationTest, RefusesOnePoseSeenAgainAndAgain) {
  const std::vector<Eigen::Isometry3d> poses(12, sample_pose(board_, 0.5, 0.5, 700.0, 25.0, 10.0));
  EXPECT_THAT(refusal(sample_views(board_, poses, kNoisePx, 4)),
              HasSubstr("in only 1 different poses"));
}

TEST_F(LensCalibrationTest, RefusesParallelBoards) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 14; ++i) {
    poses.push_back(
        sample_pose(board_, 0.3 + 0.2 * (i % 3), 0.3 + 0.2 * (i / 3 % 3), 600.0 + 50.0 * i, 0, 0));
  }
  EXPECT_THAT(refusal(sample_views(board_, poses, kNoisePx, 5)), HasSubstr("nearly parallel"));
}

TEST_F(LensCalibrationTest, RefusesViewsOfTheMiddleAlone) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 16; ++i) {
    poses.push_back(sample_pose(board_,
                                0.5,
                                0.5,
                                1500.0 + 20.0 * i,
                                i % 2 == 0 ? 35.0 : -35.0,
                                i / 2 % 2 == 0 ? 35.0 : -35.0));
  }
  EXPECT_THAT(refusal(sample_views(board_, poses, 0.02, 6)), HasSubstr("of the picture's width"));
}

TEST_F(LensCalibrationTest, LeavesOutAViewThatFitsNotAndNamesIt) {
  auto views = sample_views(board_, sample_poses(board_, 16), kNoisePx, 7);
  // It moved while the picture was taken: its right half is elsewhere.
  for (auto& corner : views[5].sighting.corners) {
    if (corner.id % board_.corner_columns() > 4) corner.px.y() += 6.0;
  }
  const auto lens = calibrate(views).value();
  EXPECT_FALSE(lens.views[5].is_used);
  EXPECT_THAT(lens.views[5].reason, HasSubstr("does not fit the others"));
  EXPECT_NEAR(lens.camera.focal_x_px, sample_lens().focal_x_px, 1.1);
}

TEST_F(LensCalibrationTest, RefusesTwoBoardsInOneSet) {
  auto views = sample_views(board_, sample_poses(board_, 16), kNoisePx, 8);
  // In every other view the board's right half stands half a square aside.
  const auto poses = sample_poses(board_, 16);
  for (std::size_t i = 0; i < views.size(); i += 2) {
    for (auto& corner : views[i].sighting.corners) {
      Eigen::Vector3d place = board_.corner_mm(corner.id);
      if (corner.id % board_.corner_columns() > 4) place.x() += 0.5 * board_.square_mm;
      if (const auto px = sample_lens().project(poses[i] * place)) corner.px = *px;
    }
  }
  const auto sentence = refusal(views);
  EXPECT_THAT(sentence,
              testing::AnyOf(HasSubstr("do not fit one flat board"), HasSubstr("two boards")));
}

TEST_F(LensCalibrationTest, CoverageAsksForWhatIsMissingInPlainWords) {
  const auto coverage = [&](const std::vector<BoardSighting>& views, int wanted) {
    return coverage_of(
        board_, views, std::vector<bool>(views.size(), false), sample_lens(), {.in_hand = wanted});
  };
  std::vector<BoardSighting> sightings;
  EXPECT_EQ(coverage(sightings, 18).missing.size(), 9U + 4U);
  for (const auto& view : sample_views(board_, sample_poses(board_, 18), 0.0, 1)) {
    sightings.push_back(view.sighting);
  }
  EXPECT_THAT(coverage(sightings, 18).missing, IsEmpty());
  EXPECT_THAT(coverage(sightings, 20).missing, testing::ElementsAre(HasSubstr("take 2 more")));
  std::vector<BoardSighting> middle(
      9, sample_views(board_, {sample_pose(board_, 0.5, 0.5, 900.0, 0, 0)}, 0.0, 1)[0].sighting);
  const auto missing = coverage(middle, 8).missing;
  EXPECT_THAT(missing, testing::Contains(HasSubstr("upper left corner of the picture")));
  EXPECT_THAT(missing, testing::Contains(HasSubstr("its left edge is nearer")));
  EXPECT_THAT(missing,
              testing::Contains(HasSubstr("change the distance: so far the board was 90")));
}

TEST_F(LensCalibrationTest, CoverageAsksForTheWallWhenTheHandHasDone) {
  std::vector<BoardSighting> sightings;
  std::vector<bool> on_wall;
  const auto add_on_wall = [&](double distance_mm) {
    const auto pose = sample_pose(board_, 0.5, 0.5, distance_mm, 4.0, 3.0);
    sightings.push_back(sample_views(board_, {pose}, 0.0, 1)[0].sighting);
    on_wall.push_back(true);
  };
  const auto missing = [&] {
    return coverage_of(board_, sightings, on_wall, sample_lens(), {.in_hand = 18, .on_wall = 3})
        .missing;
  };
  for (const auto& view : sample_views(board_, sample_poses(board_, 18), 0.0, 1)) {
    sightings.push_back(view.sighting);
    on_wall.push_back(false);
  }
  EXPECT_THAT(missing(),
              testing::ElementsAre(HasSubstr("flat wall, or lay it on a wide table, for 3")));
  add_on_wall(800.0);
  EXPECT_THAT(missing(),
              testing::ElementsAre(HasSubstr("nearer to the wall: 50 to 65 cm; so far it was 80")));
  add_on_wall(550.0);
  EXPECT_THAT(missing(), testing::ElementsAre(HasSubstr("farther from the wall")));
  add_on_wall(1100.0);
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(LensCalibrationTest, SaysWhichEdgeOfTheBoardIsNearer) {
  const auto place = [&](double tilt_x_deg, double tilt_y_deg) {
    const auto views = sample_views(
        board_, {sample_pose(board_, 0.5, 0.5, 800.0, tilt_x_deg, tilt_y_deg)}, 0.0, 1);
    return place_of(board_, views[0].sighting, sample_lens()).value();
  };
  EXPECT_NEAR(place(0.0, 20.0).right_nearer_deg, 20.0, 0.5);
  EXPECT_NEAR(place(0.0, 20.0).low_nearer_deg, 0.0, 0.5);
  EXPECT_NEAR(place(20.0, 0.0).low_nearer_deg, -20.0, 0.5);
  EXPECT_NEAR(place(0.0, 0.0).distance_mm, 800.0, 2.0);
}

}  // namespace
}  // namespace mor
