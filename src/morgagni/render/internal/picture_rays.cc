// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/picture_rays.h"

#include <tbb/parallel_for.h>

namespace mor::internal {

void PictureRays::update(const PinholeCamera& camera) {
  if (camera == camera_) return;
  camera_ = camera;
  rays_.resize(static_cast<std::size_t>(camera.width_px) * camera.height_px);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    Eigen::Vector2f* row = rays_.data() + static_cast<std::size_t>(y) * camera.width_px;
    for (int x = 0; x < camera.width_px; ++x) {
      row[x] = camera.ray(Eigen::Vector2d(x, y)).cast<float>();
    }
  });
}

}  // namespace mor::internal
