// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/depth_readings.h"

#include <algorithm>
#include <cmath>

namespace mor {
namespace {

constexpr int kBlockPx = 8;
/// A block counts where so many of its pixels have a reading of the plane.
constexpr int kMinInBlock = kBlockPx * kBlockPx / 2;
/// A reading farther from the plane than this share of the distance is of something else.
constexpr double kOffPlaneShare = 0.05;
constexpr double kRoughlyOffPlaneShare = 0.33;
/// The board is read to so much of its outer squares.
constexpr double kOuterShare = 0.6;
/// Where it hangs on a wall, so many times its area around it is in its plane.
constexpr double kWallAreas = 2.0;

/// Pixel by pixel: how far along its ray the board's plane is, and whether that is on the board.
struct PlaneView {
  PlaneView(const CalibrationBoard& board, const Eigen::Isometry3d& depth_from_board, double outer)
      : normal(depth_from_board.linear().col(2)),
        distance_mm(normal.dot(depth_from_board.translation())),
        board_from_depth(depth_from_board.inverse()),
        least(Eigen::Vector2d::Constant(-outer * board.square_mm)),
        most(board.corner_mm(board.num_corners() - 1).head<2>() - least) {}

  [[nodiscard]] double depth_mm(const Eigen::Vector2d& ray) const {
    return distance_mm / normal.dot(ray.homogeneous());
  }
  [[nodiscard]] bool is_on_board(const Eigen::Vector2d& ray, double z_mm) const {
    const Eigen::Vector2d p = (board_from_depth * (z_mm * ray.homogeneous())).head<2>();
    return (p.array() >= least.array()).all() && (p.array() <= most.array()).all();
  }

  Eigen::Vector3d normal;
  double distance_mm;
  Eigen::Isometry3d board_from_depth;
  Eigen::Vector2d least;
  Eigen::Vector2d most;
};

bool is_plausible(double seen_mm, double true_mm, BoardArea area) {
  const double share = area == BoardArea::kRough ? kRoughlyOffPlaneShare : kOffPlaneShare;
  return true_mm > 0.0 && std::abs(seen_mm - true_mm) < share * true_mm;
}

}  // namespace

DepthReader::DepthReader(const PinholeCamera& depth_camera) : camera_(depth_camera) {
  rays_.reserve(static_cast<std::size_t>(camera_.width_px) *
                static_cast<std::size_t>(camera_.height_px));
  for (int y = 0; y < camera_.height_px; ++y) {
    for (int x = 0; x < camera_.width_px; ++x) rays_.push_back(camera_.ray(Eigen::Vector2d(x, y)));
  }
}

int DepthReader::num_blocks() const {
  return (camera_.width_px / kBlockPx) * (camera_.height_px / kBlockPx);
}

std::vector<DepthReading> DepthReader::read(const Image<float>& depth_mm,
                                            const CalibrationBoard& board,
                                            const Eigen::Isometry3d& depth_from_board,
                                            BoardArea area,
                                            int view) const {
  const bool is_whole = area == BoardArea::kWhole;
  const PlaneView plane(board, depth_from_board, is_whole ? kOuterShare : 0.0);
  std::vector<DepthReading> on_board;
  std::vector<DepthReading> around;
  if (depth_mm.width() != camera_.width_px || depth_mm.height() != camera_.height_px) return {};
  for (int top = 0; top + kBlockPx <= camera_.height_px; top += kBlockPx) {
    for (int left = 0; left + kBlockPx <= camera_.width_px; left += kBlockPx) {
      DepthReading reading{.view = view};
      int count = 0;
      int num_on_board = 0;
      for (int k = 0; k < kBlockPx * kBlockPx; ++k) {
        const int x = left + k % kBlockPx;
        const int y = top + k / kBlockPx;
        const auto seen_mm = static_cast<double>(depth_mm(x, y));
        if (seen_mm <= 0.0) continue;
        const Eigen::Vector2d& ray =
            rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width_px) +
                  static_cast<std::size_t>(x)];
        const double true_mm = plane.depth_mm(ray);
        if (!is_plausible(seen_mm, true_mm, area)) continue;
        num_on_board += plane.is_on_board(ray, true_mm) ? 1 : 0;
        reading.px += Eigen::Vector2d(x, y);
        reading.seen_mm += seen_mm;
        reading.true_mm += true_mm;
        ++count;
      }
      if (count < kMinInBlock) continue;
      reading.px /= count;
      reading.seen_mm /= count;
      reading.true_mm /= count;
      if (num_on_board == count) {
        on_board.push_back(reading);
      } else if (num_on_board == 0) {
        reading.is_beside = true;
        around.push_back(reading);
      }
    }
  }
  // A hand that holds the board is no wall: it is small.
  if (is_whole &&
      static_cast<double>(around.size()) > kWallAreas * static_cast<double>(on_board.size())) {
    on_board.insert(on_board.end(), around.begin(), around.end());
  }
  return on_board;
}

}  // namespace mor
