// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"

namespace mor::internal {

/// A depth picture made small and free of lens distortion, as the automatic start looks at it.
struct StartPicture {
  PinholeCamera camera;  ///< Without distortion.
  Image<float> z_mm;     ///< 0: no reading.
  /// The same, each the mean of the readings around it on its surface: a fifth of the noise.
  Image<float> even_mm;
  float noise_share = 1.0F;  ///< Of a single picture's noise, what is left in `z_mm`.

  [[nodiscard]] Eigen::Vector3f point(int x, int y) const { return point_at(x, y, z_mm(x, y)); }
  [[nodiscard]] Eigen::Vector3f even_point(int x, int y) const {
    return point_at(x, y, even_mm(x, y));
  }
  /// What a pixel sees at depth `z`.
  [[nodiscard]] Eigen::Vector3f point_at(int x, int y, float z) const {
    return {z * (static_cast<float>(x) - static_cast<float>(camera.center_x_px)) /
                static_cast<float>(camera.focal_x_px),
            z * (static_cast<float>(y) - static_cast<float>(camera.center_y_px)) /
                static_cast<float>(camera.focal_y_px),
            z};
  }

  /// The unit normal, towards the camera, of the plane through the readings within `radius_mm` on
  /// the picture. None where they are few.
  [[nodiscard]] std::optional<Eigen::Vector3f> normal(int x, int y, float radius_mm) const;
};

/// Another picture of the same still scene.
struct OtherPicture {
  const StartPicture* picture = nullptr;
  Eigen::Isometry3d other_from_this = Eigen::Isometry3d::Identity();
};

/// The mean of the readings in 5x5 pixels around each that lie on the same surface. In pairs about
/// the middle, so that a slope adds nothing.
[[nodiscard]] Image<float> evened(const Image<float>& z_mm);

/// Makes such pictures; what depends on the camera alone is computed once.
class StartPictureMaker {
 public:
  explicit StartPictureMaker(const PinholeCamera& depth_camera);

  /// Readings beyond `max_mm` are dropped. @param depth_mm  Of the depth camera's size.
  [[nodiscard]] StartPicture make(ImageView<const std::uint16_t> depth_mm, float max_mm) const;

 private:
  /// The block of source pixels that a small pixel looks at; its upper left corner, -1: none.
  struct Block {
    int x = -1;
    int y = -1;
  };

  PinholeCamera small_camera_;
  int side_ = 1;  ///< Of a block.
  std::vector<Block> blocks_;
};

}  // namespace mor::internal
