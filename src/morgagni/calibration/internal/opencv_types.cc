// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/opencv_types.h"

#include <algorithm>

#include <opencv2/calib3d.hpp>

namespace mor::internal {
namespace {

cv::Point3f on_board(const CalibrationBoard& board, int id) {
  const Eigen::Vector3f p = board.corner_mm(id).cast<float>();
  return {p.x(), p.y(), p.z()};
}

cv::Point2f in_picture(const SeenCorner& corner) {
  const Eigen::Vector2f p = corner.px.cast<float>();
  return {p.x(), p.y()};
}

}  // namespace

cv::Matx33d matrix_of(const PinholeCamera& camera) {
  return {camera.focal_x_px,
          0.0,
          camera.center_x_px,
          0.0,
          camera.focal_y_px,
          camera.center_y_px,
          0.0,
          0.0,
          1.0};
}

std::vector<double> distortion_of(const PinholeCamera& camera) {
  return {camera.distortion.begin(), camera.distortion.end()};
}

PinholeCamera pinhole_of(const cv::Mat& matrix,
                         const cv::Mat& distortion,
                         int width_px,
                         int height_px) {
  PinholeCamera camera{width_px,
                       height_px,
                       matrix.at<double>(0, 0),
                       matrix.at<double>(1, 1),
                       matrix.at<double>(0, 2),
                       matrix.at<double>(1, 2),
                       {}};
  const int count = std::min<int>(static_cast<int>(distortion.total()),
                                  static_cast<int>(camera.distortion.size()));
  for (int i = 0; i < count; ++i) {
    camera.distortion[static_cast<std::size_t>(i)] = distortion.at<double>(i);
  }
  return camera;
}

Eigen::Isometry3d rigid_of(const cv::Mat& rotation, const cv::Mat& shift) {
  cv::Mat matrix = rotation;
  if (rotation.total() == 3) cv::Rodrigues(rotation, matrix);
  Eigen::Isometry3d rigid = Eigen::Isometry3d::Identity();
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) rigid.linear()(y, x) = matrix.at<double>(y, x);
    rigid.translation()[y] = shift.at<double>(y);
  }
  return rigid;
}

Correspondences correspondences_of(const CalibrationBoard& board, const BoardSighting& sighting) {
  Correspondences result;
  for (const auto& corner : sighting.corners) {
    result.board_mm.push_back(on_board(board, corner.id));
    result.px.push_back(in_picture(corner));
  }
  return result;
}

SharedCorners shared_corners(const CalibrationBoard& board,
                             const BoardSighting& first,
                             const BoardSighting& second) {
  SharedCorners result;
  for (const auto& corner : first.corners) {
    const auto same = std::ranges::find(second.corners, corner.id, &SeenCorner::id);
    if (same == second.corners.end()) continue;
    result.board_mm.push_back(on_board(board, corner.id));
    result.first_px.push_back(in_picture(corner));
    result.second_px.push_back(in_picture(*same));
  }
  return result;
}

}  // namespace mor::internal
