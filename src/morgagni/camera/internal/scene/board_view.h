// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/camera/internal/kinect_noise.h"
#include "morgagni/camera/simulated_board_camera.h"
#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

struct BoardLook {
  double blur_px = 0.0;
  double grain = 0.0;
  std::uint64_t seed = 0;
};

/// Draws a flat board through a lens that distorts: nine rays a pixel, each answered by the board's
/// picture at the resolution at which it appears.
class BoardView {
 public:
  BoardView(BoardPicture board, const PinholeCamera& camera);

  /// What is printed, and what is behind it, before light and lens. @cost About 0.1 s.
  [[nodiscard]] Image<float> drawn(const Eigen::Isometry3d& camera_from_board,
                                   bool is_on_wall) const;

  /// Grey, lit unevenly, blurred by the lens, with the sensor's grain.
  /// @param contrast  Of black to white, 1: full.
  [[nodiscard]] Image<Rgb8> picture(Image<float> drawn,
                                    const BoardLook& look,
                                    double contrast) const;

  /// What an ideal range camera would see of the board and of what is behind it: the wall it hangs
  /// on, or one at 2.4 m.
  [[nodiscard]] IdealDepth depth(const Eigen::Isometry3d& camera_from_board, bool is_on_wall) const;

 private:
  [[nodiscard]] float brightness(double x_mm, double y_mm, double px_mm) const;
  [[nodiscard]] bool is_on_board(double x_mm, double y_mm) const;

  std::vector<Image<float>> levels_;  ///< Each of half the resolution of the one before.
  double mm_per_px_;
  Eigen::Vector2d first_px_mm_;
  Eigen::Vector2d size_mm_;
  PinholeCamera camera_;
  Image<Eigen::Vector2d> rays_;  ///< With one pixel more around the picture.
};

}  // namespace mor::internal
