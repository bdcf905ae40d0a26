// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

TEST(CalibrationBoard, IsReadAndWrittenAsText) {
  for (const char* text : {"charuco:11x8:24:18", "chessboard:8x5:31.5", "charuco:5x4:2.5:1.25"}) {
    const auto board = parse_board(text);
    ASSERT_TRUE(board) << board.error().message;
    EXPECT_EQ(to_string(*board), text);
  }
  EXPECT_EQ(parse_board(to_string(CalibrationBoard{})).value(), CalibrationBoard{});
}

TEST(CalibrationBoard, HasItsCornersInsideRowByRow) {
  const auto board = parse_board("chessboard:8x5:30").value();
  EXPECT_EQ(board.num_corners(), 28);
  EXPECT_EQ(board.corner_mm(0), Eigen::Vector3d(0.0, 0.0, 0.0));
  EXPECT_EQ(board.corner_mm(8), Eigen::Vector3d(30.0, 30.0, 0.0));
}

TEST(CalibrationBoard, SaysWhatIsWrongWithIt) {
  const auto message = [](const char* text) { return parse_board(text).error().message; };
  EXPECT_THAT(message("circles:4x11:20"), HasSubstr("'circles:4x11:20' must be charuco:"));
  EXPECT_THAT(message(""), HasSubstr("must be charuco:"));
  EXPECT_THAT(message("charuco:11x8:24"), HasSubstr("must be charuco:"));
  EXPECT_THAT(message("chessboard:11:24"), HasSubstr("'11' must be COLUMNSxROWS"));
  EXPECT_THAT(message("chessboard:11xa:24"), HasSubstr("'a' is no number"));
  EXPECT_THAT(message("chessboard:11x8:24mm"), HasSubstr("'24mm' is no number"));
  EXPECT_THAT(message("chessboard:3x8:24"), HasSubstr("4..40 squares along each side, got 3 x 8"));
  EXPECT_THAT(message("chessboard:8x6:24"), HasSubstr("one number must be odd"));
  EXPECT_THAT(message("chessboard:8x7:nan"), HasSubstr("2..500 mm wide"));
  EXPECT_THAT(message("charuco:8x7:24:23"), HasSubstr("0.3..0.9 of a square's 24 mm wide, got 23"));
}

}  // namespace
}  // namespace mor
