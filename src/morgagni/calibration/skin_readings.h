// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/depth_levels.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// The mean of a block of neighbouring depth readings that lie on the CT's skin.
struct SkinReading {
  static constexpr int kBlockPx = 4;

  std::uint16_t column = 0;  ///< Of the block in the picture.
  std::uint16_t row = 0;
  std::uint16_t used = 0;                           ///< Its pixels that count, a bit each.
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< Their mean.
  float z_mm = 0.0F;                                ///< Their mean.
};

/// One moment of the camera, reduced to what self-calibration uses: about 100 kB.
struct SensedSkin {
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();  ///< As tracked.
  std::vector<SkinReading> readings;
  /// Of what is seen beside the body, thinned out: it may lie on a table.
  std::vector<SkinReading> beside;
};

/// How a Kinect's readings stray sideways (Nguyen et al. 2012).
inline constexpr double kReadingBlurPx = 0.8;

/// What an ideal camera would read in a block.
struct ExpectedReading {
  float z_mm =
      0.0F;  ///< Mean over the pixels that count. 0: the block shows no whole patch of skin.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< Of the skin there, frame depth.
};

/// The skin's depth picture as an ideal camera sees it, lens distortion included, blurred sideways
/// as a sensor's readings stray (Nguyen et al. 2012). 0: nothing.
/// @cost About 8 ms at 640x480.
[[nodiscard]] Image<float> expected_depth(const TriangleMesh& skin,
                                          const PinholeCamera& camera,
                                          const Eigen::Isometry3d& ct_from_depth);

/// Reads the skin in a depth picture: the means of blocks of readings near the skin as a picture
/// drawn at the pose shows it, and of smooth blocks beside it. Blocks at edges or partly covered
/// are left out.
/// @param depth_mm  As the sensor gave it, of the camera's size; 0 = no reading.
/// @param levels  What its values stand for: of this camera, learned from its pictures.
/// @param ct_from_depth  The pose, right to some millimetres.
[[nodiscard]] SensedSkin read_skin(const TriangleMesh& skin,
                                   const PinholeCamera& camera,
                                   ImageView<const std::uint16_t> depth_mm,
                                   const DepthLevels& levels,
                                   const Eigen::Isometry3d& ct_from_depth);

/// The same block in `expected`, which expected_depth() drew for `camera`.
[[nodiscard]] ExpectedReading expected_reading(const SkinReading& reading,
                                               const Image<float>& expected,
                                               const PinholeCamera& camera);

}  // namespace mor
