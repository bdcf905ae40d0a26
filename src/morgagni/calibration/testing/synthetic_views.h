// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "morgagni/calibration/lens_calibration.h"

/// Boards in pictures without pictures: corners where a known lens puts them, with noise.
namespace mor::internal {

inline PinholeCamera sample_lens() {
  return {640, 480, 533.0, 531.5, 316.2, 244.1, {0.08, -0.1, 0.001, -0.0008, 0.0}};
}

/// The board's middle at a share of the picture's width and height, tilted about x and y.
inline Eigen::Isometry3d sample_pose(const CalibrationBoard& board,
                                     double share_x,
                                     double share_y,
                                     double distance_mm,
                                     double tilt_x_deg,
                                     double tilt_y_deg) {
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  const auto lens = sample_lens();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(tilt_x_deg * kRadPerDeg, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(tilt_y_deg * kRadPerDeg, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  const Eigen::Vector3d middle = 0.5 * board.corner_mm(board.num_corners() - 1);
  pose.translation() = distance_mm * lens.ray({share_x * 640.0, share_y * 480.0}).homogeneous() -
                       pose.linear() * middle;
  return pose;
}

/// What a lens sees of the board there; corners outside the picture are missing.
inline BoardSighting sighting_at(const CalibrationBoard& board,
                                 const PinholeCamera& lens,
                                 const Eigen::Isometry3d& camera_from_board,
                                 double noise_px,
                                 std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, noise_px);
  BoardSighting sighting{.corners = {}, .edge_width_px = 1.2, .square_px = 25.0};
  for (int id = 0; id < board.num_corners(); ++id) {
    const auto px = lens.project(camera_from_board * board.corner_mm(id));
    if (!px || px->x() < 4.0 || px->y() < 4.0 || px->x() > lens.width_px - 5.0 ||
        px->y() > lens.height_px - 5.0) {
      continue;
    }
    sighting.corners.push_back({id, *px + Eigen::Vector2d(noise(random), noise(random))});
  }
  return sighting;
}

/// Views all over the picture, near and far, tilted all ways.
inline std::vector<Eigen::Isometry3d> sample_poses(const CalibrationBoard& board, int count) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(sample_pose(board,
                                0.24 + 0.26 * (i % 3),
                                0.26 + 0.24 * (i / 3 % 3),
                                560.0 + 90.0 * (i * 5 % 7),
                                i % 2 == 0 ? 26.0 : -24.0,
                                i / 2 % 2 == 0 ? 22.0 : -27.0));
  }
  return poses;
}

inline std::vector<LensView> sample_views(const CalibrationBoard& board,
                                          const std::vector<Eigen::Isometry3d>& poses,
                                          double noise_px,
                                          std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<LensView> views;
  for (const auto& pose : poses) {
    views.push_back({"view " + std::to_string(views.size() + 1),
                     sighting_at(board, sample_lens(), pose, noise_px, random)});
  }
  return views;
}

}  // namespace mor::internal
