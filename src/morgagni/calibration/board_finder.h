// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/calibration/board.h"
#include "morgagni/core/image.h"

namespace mor {

/// An inner corner of a board in a picture.
struct SeenCorner {
  int id = 0;  ///< As CalibrationBoard::corner_mm() counts.
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
};

/// A board in a picture.
struct BoardSighting {
  std::vector<SeenCorner> corners;  ///< By rising id. At least four, not on one line.
  /// Width of the squares' edges, from 10 to 90 % of the way between black and white, by their
  /// steepness; median. What blur and motion make of them; about 1 px at best.
  double edge_width_px = 0.0;
  double square_px = 0.0;  ///< Side of a square, median.
};

struct BoardSearch {
  std::vector<BoardSighting> found;  ///< One, or none.
  std::string reason;                ///< Why there is none, in words.
};

/// Looks for a board: chessboards by OpenCV's sector-based finder, ChArUco boards by their markers.
/// A chessboard is counted from its own upper left, whichever way up it is held.
/// @pre board.check().  @threads Reentrant.
/// @cost At 640x480 about 0.4 s for a chessboard, 20 ms for a ChArUco board.
[[nodiscard]] BoardSearch find_board(ImageView<const std::uint8_t> grey,
                                     const CalibrationBoard& board);

/// The same in a colour picture.
[[nodiscard]] BoardSearch find_board(ImageView<const Rgb8> color, const CalibrationBoard& board);

}  // namespace mor
