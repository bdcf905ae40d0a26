// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// (x/z, y/z) of the ray of each pixel of a camera's picture, lens distortion removed.
class PictureRays {
 public:
  /// Costs only where the camera is another one than before.
  void update(const PinholeCamera& camera);

  [[nodiscard]] const Eigen::Vector2f* row(int y) const {
    return rays_.data() + static_cast<std::size_t>(y) * camera_.width_px;
  }

 private:
  PinholeCamera camera_;
  std::vector<Eigen::Vector2f> rays_;
};

}  // namespace mor::internal
