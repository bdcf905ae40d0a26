// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Geometry>

#include "morgagni/camera/simulated_camera.h"

namespace mor::internal {

/// Where a careful hand holds the camera: a few slow sinusoids with seeded phases about the place
/// straight in front of the body, and a tremor. Never faster than 0.15 m/s and 20 degrees/s.
class HandPath {
 public:
  /// @param bounds  Of the skin, frame ct (LPS, supine: anterior is -y).
  /// @param distance_mm  From the camera to the body's foremost point, at the start.
  HandPath(const Eigen::AlignedBox3f& bounds,
           double distance_mm,
           SimulatedPath path,
           std::uint64_t seed);

  [[nodiscard]] Eigen::Isometry3d ct_from_camera(double time_s) const;

 private:
  static constexpr std::size_t kNumMotions = 7;
  struct Motion {
    double amplitude = 0.0;
    double period_s = 1.0;
    double phase_rad = 0.0;
  };
  [[nodiscard]] double value(std::size_t motion, double time_s) const;
  [[nodiscard]] double tremor(std::size_t axis, double time_s) const;

  SimulatedPath path_;
  Eigen::Vector3d target_;  ///< What the hand keeps in the picture's middle, frame ct.
  double target_distance_mm_;
  std::array<Motion, kNumMotions> motions_;
  std::array<double, kNumMotions> start_;  ///< Held from the first moment on.
  std::array<double, 6> tremor_phase_rad_;
};

}  // namespace mor::internal
