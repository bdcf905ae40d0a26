// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// How hard a frame is for any method, by its true pose.
struct FrameDifficulty {
  /// Of the pixels that show the body from outside or what covers it there, the share that measures
  /// the body, 0..1. What a simulated camera sees of the inside, through an end where the CT was
  /// cut off, is no skin that a real one could see.
  double bare_share = 0.0;
  /// Cramer-Rao bound of the target registration error, mm: no unbiased method is better over many
  /// draws of the noise, root mean square, even if told which readings are the body's. Infinite
  /// where the readings leave a direction open.
  double least_tre_mm = 0.0;
};

/// @param depth_mm  Of `camera`'s size; 0 = no reading. With the noise of a Kinect v1
///        (kinect_noise_model.h), which the bound goes by.
/// @param targets  >= 1. @cost About 10 ms at 640x480.
[[nodiscard]] FrameDifficulty frame_difficulty(const TriangleMesh& skin,
                                               ImageView<const std::uint16_t> depth_mm,
                                               const PinholeCamera& camera,
                                               const Eigen::Isometry3d& ct_from_depth_truth,
                                               const std::vector<Target>& targets);

}  // namespace mor
