// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/board_finder.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/calibration/board_pattern.h"
#include "morgagni/calibration/lens_calibration.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::SizeIs;

std::unique_ptr<SimulatedBoardCamera> camera_before(const CalibrationBoard& board,
                                                    const std::string& options) {
  return SimulatedBoardCamera::create(board_picture(board),
                                      SimulatedBoardOptions::parse(options).value())
      .value();
}

Eigen::Isometry3d true_pose(const SimulatedBoardCamera& camera, std::uint64_t pose) {
  return camera.truth().color_from_depth * camera.depth_from_board(pose);
}

Image<Rgb8> turned_by_half(const Image<Rgb8>& picture) {
  Image<Rgb8> turned(picture.width(), picture.height());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    turned.data()[i] = picture.data()[picture.size() - 1 - i];
  }
  return turned;
}

TEST(BoardFinder, PlacesAChessboardsCornersToATenthOfAPixelWhicheverWayUp) {
  const CalibrationBoard board{.kind = BoardKind::kChessboard};
  const auto camera = camera_before(board, "seed=3,near=700,far=800,tilt=15");
  const auto frame = camera->frame_at(1, 0);  // In the picture's middle.
  const auto search = find_board(frame->color.view(), board);
  ASSERT_THAT(search.found, SizeIs(1)) << search.reason;
  EXPECT_THAT(search.found[0].corners, SizeIs(54));
  EXPECT_LT(
      reprojection_rms_px(board, search.found[0], camera->truth().color, true_pose(*camera, 1)),
      0.1);
  const auto again = find_board(turned_by_half(frame->color).view(), board);
  ASSERT_THAT(again.found, SizeIs(1)) << again.reason;
  for (std::size_t i = 0; i < 54; ++i) {
    const Eigen::Vector2d turned(639.0 - again.found[0].corners[i].px.x(),
                                 479.0 - again.found[0].corners[i].px.y());
    EXPECT_LT((turned - search.found[0].corners[i].px).norm(), 0.1) << i;
  }
}

TEST(BoardFinder, PlacesTheCornersOfACharucoBoardThatIsSeenInPart) {
  const CalibrationBoard board;
  const auto camera = camera_before(board, "seed=3,near=450,far=900");
  std::size_t fewest = 54;
  int num_found = 0;
  for (std::uint64_t pose = 0; pose < 9; ++pose) {
    const auto search = find_board(camera->frame_at(pose, 0)->color.view(), board);
    if (search.found.empty()) continue;
    ++num_found;
    fewest = std::min(fewest, search.found[0].corners.size());
    EXPECT_LT(reprojection_rms_px(
                  board, search.found[0], camera->truth().color, true_pose(*camera, pose)),
              0.25)
        << pose;
  }
  EXPECT_GE(num_found, 7);
  EXPECT_LT(fewest, 54U);
}

TEST(BoardFinder, MeasuresBlur) {
  const CalibrationBoard board;
  const auto width = [&](const char* options) {
    const auto camera = camera_before(board, options);
    return find_board(camera->frame_at(1, 0)->color.view(), board).found.at(0).edge_width_px;
  };
  const double sharp_px = width("seed=3,near=600,far=650,blur=0.5");
  const double blurred_px = width("seed=3,near=600,far=650,blur=1.2");
  EXPECT_LT(sharp_px, 2.2);
  // A Gaussian goes from 10 to 90 % in 2.56 standard deviations.
  EXPECT_NEAR(blurred_px, 2.56 * 1.2, 0.6);
}

TEST(BoardFinder, TellsAnotherBoard) {
  const CalibrationBoard shown{.columns = 12, .rows = 9, .square_mm = 30.0, .marker_mm = 20.0};
  const CalibrationBoard small{.columns = 5, .rows = 4, .square_mm = 30.0, .marker_mm = 20.0};
  const auto picture = camera_before(shown, "seed=3,near=600,far=700")->frame_at(1, 0)->color;
  EXPECT_THAT(find_board(picture.view(), small).reason, HasSubstr("another board is seen"));
  CalibrationBoard other_markers = shown;
  other_markers.marker_mm = 12.0;
  EXPECT_THAT(find_board(picture.view(), other_markers).reason, HasSubstr("of a square wide"));
}

TEST(BoardFinder, SaysWhereThereIsNone) {
  const Image<Rgb8> grey(320, 240, Rgb8{90, 90, 90});
  EXPECT_THAT(find_board(grey.view(), CalibrationBoard{}).reason, HasSubstr("no board is seen"));
  EXPECT_THAT(find_board(grey.view(), CalibrationBoard{.kind = BoardKind::kChessboard}).reason,
              HasSubstr("no chessboard"));
  EXPECT_THAT(find_board(ImageView<const Rgb8>(), CalibrationBoard{}).reason,
              HasSubstr("no picture"));
}

TEST(BoardPattern, CoversNothingTwice) {
  const CalibrationBoard board;
  const auto black = black_rectangles(board);
  for (std::size_t i = 0; i < black.size(); ++i) {
    const auto& a = black[i];
    EXPECT_LT(a.left_mm, a.right_mm);
    EXPECT_LT(a.top_mm, a.bottom_mm);
    for (std::size_t k = i + 1; k < black.size(); ++k) {
      const auto& b = black[k];
      const double across = std::min(a.right_mm, b.right_mm) - std::max(a.left_mm, b.left_mm);
      const double down = std::min(a.bottom_mm, b.bottom_mm) - std::max(a.top_mm, b.top_mm);
      ASSERT_FALSE(across > 1e-9 && down > 1e-9) << i << " " << k;
    }
  }
}

TEST(BoardPattern, IsPrintedAtItsTrueSizeAndFoundOnThePage) {
  const auto folder = fs::temp_directory_path() / ("mor_board_" + std::to_string(getpid()));
  fs::create_directories(folder);
  for (const char* text : {"charuco:10x7:37:24", "chessboard:8x5:30"}) {
    const auto board = parse_board(text).value();
    ASSERT_TRUE(write_board_pdf(board, folder / "board.pdf"));
    // At 127 dpi a millimetre is five pixels.
    const auto command = "pdftoppm -r 127 -png -singlefile " + (folder / "board.pdf").string() +
                         " " + (folder / "board").string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    const auto page = read_png_rgb(folder / "board.png").value();
    const auto search = find_board(page.view(), board);
    ASSERT_THAT(search.found, SizeIs(1)) << text << ": " << search.reason;
    const auto& corners = search.found[0].corners;
    ASSERT_THAT(corners, SizeIs(static_cast<std::size_t>(board.num_corners())));
    const Eigen::Vector2d diagonal_mm = board.corner_mm(board.num_corners() - 1).head<2>();
    EXPECT_LT((corners.back().px - corners.front().px - 5.0 * diagonal_mm).norm(), 1.5) << text;
  }
  EXPECT_THAT(write_board_pdf(CalibrationBoard{}, folder / "none" / "board.pdf").error().message,
              HasSubstr("board.pdf"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace mor
