// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "morgagni/calibration/board.h"
#include "morgagni/calibration/board_finder.h"
#include "morgagni/geometry/pinhole_camera.h"

/// Between our types and OpenCV's.
namespace mor::internal {

[[nodiscard]] cv::Matx33d matrix_of(const PinholeCamera& camera);
[[nodiscard]] std::vector<double> distortion_of(const PinholeCamera& camera);
[[nodiscard]] PinholeCamera pinhole_of(const cv::Mat& matrix,
                                       const cv::Mat& distortion,
                                       int width_px,
                                       int height_px);
[[nodiscard]] Eigen::Isometry3d rigid_of(const cv::Mat& rotation, const cv::Mat& shift);

/// Corners on the board, mm, and in the picture, in the same order.
struct Correspondences {
  std::vector<cv::Point3f> board_mm;
  std::vector<cv::Point2f> px;
};
[[nodiscard]] Correspondences correspondences_of(const CalibrationBoard& board,
                                                 const BoardSighting& sighting);

/// Those that two sightings share.
struct SharedCorners {
  std::vector<cv::Point3f> board_mm;
  std::vector<cv::Point2f> first_px;
  std::vector<cv::Point2f> second_px;
};
[[nodiscard]] SharedCorners shared_corners(const CalibrationBoard& board,
                                           const BoardSighting& first,
                                           const BoardSighting& second);

}  // namespace mor::internal
