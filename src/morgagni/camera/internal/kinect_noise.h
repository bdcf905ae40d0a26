// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "morgagni/camera/internal/random.h"
#include "morgagni/camera/kinect_noise_model.h"
#include "morgagni/core/image.h"

namespace mor::internal {

/// What an ideal range camera would see.
struct IdealDepth {
  Image<float> z_mm;           ///< 0: nothing.
  Image<std::uint8_t> facing;  ///< Cosine between ray and surface normal, 255 = head on.
};

/// The readings of a Kinect v1, see kinect_noise_model.h.
class KinectNoise {
 public:
  /// @param focal_px  Of the pictures it is applied to.
  KinectNoise(double focal_px, std::uint64_t seed);

  /// The same picture for the same (seed, frame_id). @cost About 3 ms at 640x480.
  [[nodiscard]] Image<std::uint16_t> apply(const IdealDepth& ideal, std::uint64_t frame_id) const;

 private:
  static constexpr std::size_t kNumAngles = 64;   ///< Classes of facing, four cosines of 255 each.
  static constexpr std::size_t kNumSteps = 1024;  ///< Disparities, in steps of an eighth pixel.

  /// What depends on the angle.
  struct ByAngle {
    std::array<std::int8_t, 256> shift_px{};  ///< Quantiles of the lateral noise.
    std::uint32_t drop_below = 0;  ///< Dropped where a 16-bit random number is below this.
    /// Axial noise still to be added, in steps, for every second disparity.
    std::array<float, kNumSteps / 2> sd_steps{};
  };

  /// Farther than this no reading strays sideways.
  static constexpr int kRimPx = 6;

  [[nodiscard]] static Image<float> disparity_with_rim(const Image<float>& depth_mm);
  void mark_shadow(const float* steps, int width, std::uint8_t* is_lit) const;
  [[nodiscard]] std::uint16_t measure(float steps, const ByAngle& angle, std::uint64_t bits) const;

  double focal_px_;
  std::uint64_t seed_;
  NormalTable normal_;
  std::vector<ByAngle> by_angle_;
  std::vector<std::uint16_t> depth_of_step_mm_;  ///< 0 out of range.
};

}  // namespace mor::internal
