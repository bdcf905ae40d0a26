// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/charuco.h"

namespace mor::internal {

cv::Ptr<cv::aruco::Dictionary> marker_dictionary() {
  return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_1000);
}

cv::Mat marker_cells(int id) {
  const auto dictionary = marker_dictionary();
  cv::Mat cells;
  dictionary->drawMarker(id, dictionary->markerSize + 2, cells, 1);
  return cells;
}

cv::Ptr<cv::aruco::CharucoBoard> charuco_board(const CalibrationBoard& board) {
  return cv::aruco::CharucoBoard::create(board.columns,
                                         board.rows,
                                         static_cast<float>(board.square_mm),
                                         static_cast<float>(board.marker_mm),
                                         marker_dictionary());
}

}  // namespace mor::internal
