// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/core.hpp>

#include "morgagni/calibration/board.h"

namespace mor::internal {

/// The markers: 4x4 cells, which are large where the board is far, and more than any board needs.
[[nodiscard]] cv::Ptr<cv::aruco::Dictionary> marker_dictionary();

/// A marker with its black border, one byte a cell: 0 black, 255 white.
[[nodiscard]] cv::Mat marker_cells(int id);

/// OpenCV's form of a board; its y axis points up. @pre a ChArUco board.
[[nodiscard]] cv::Ptr<cv::aruco::CharucoBoard> charuco_board(const CalibrationBoard& board);

}  // namespace mor::internal
