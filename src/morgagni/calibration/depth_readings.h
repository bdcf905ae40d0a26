// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/board.h"
#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor {

/// What a depth camera read of a plane whose place is known: the mean over a small block of pixels.
struct DepthReading {
  int view = 0;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  ///< Of the block's middle.
  double seen_mm = 0.0;
  double true_mm = 0.0;    ///< Of the same pixels' rays on the plane.
  bool is_beside = false;  ///< Of what the board lies on, not of the board.
};

/// Which part of a board's plane is read.
enum class BoardArea : std::uint8_t {
  kRough,   ///< As kInside, with readings up to a third off the plane: is its size known right?
  kInside,  ///< Within the outer inner corners: safe where the board's place is known roughly.
  kWhole,  ///< The board to near its rim; where it lies on a wide flat thing (a wall, a table), all
           ///< of that, as far as the picture reaches.
};

/// Takes readings of boards from depth pictures of one camera.
class DepthReader {
 public:
  explicit DepthReader(const PinholeCamera& depth_camera);

  /// @param depth_mm  0 = no reading; means of several frames have fractions.
  /// @param view  Written into the readings.
  /// @return Empty where the board is not before the camera.
  [[nodiscard]] std::vector<DepthReading> read(const Image<float>& depth_mm,
                                               const CalibrationBoard& board,
                                               const Eigen::Isometry3d& depth_from_board,
                                               BoardArea area,
                                               int view) const;

  /// How many readings a picture full of the board would give.
  [[nodiscard]] int num_blocks() const;

 private:
  PinholeCamera camera_;
  std::vector<Eigen::Vector2d> rays_;
};

}  // namespace mor
