// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "morgagni/camera/internal/random.h"
#include "morgagni/core/image.h"

namespace mor::internal {

/// What an ideal range camera would see.
struct IdealDepth {
  Image<float> z_mm;           ///< 0: nothing.
  Image<std::uint8_t> facing;  ///< Cosine between ray and surface normal, 255 = head on.
};

/// The Kinect v1 as measured by Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise for improved
/// 3D reconstruction and tracking", 3DIMPVT 2012 (axial and lateral noise), and by Khoshelham and
/// Elberink, "Accuracy and resolution of Kinect depth data", Sensors 12, 2012 (disparity steps).
namespace kinect {

inline constexpr double kNearestMm = 400.0;
inline constexpr double kFarthestMm = 4000.0;
inline constexpr double kBaselineMm = 75.0;        ///< The projector stands on the +x side.
inline constexpr double kInfraredFocalPx = 580.0;  ///< Of the sensor's own 640x480 pictures.
inline constexpr double kDisparityStepPx = 0.125;

/// Nguyen et al., axial noise: 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2, plus the term that grows with the
/// angle between ray and normal, for any angle short of 90 degrees.
[[nodiscard]] double axial_sd_mm(double z_mm, double angle_rad);

/// Nguyen et al., lateral noise: 0.8 px + 0.035 px angle / (90 degrees - angle).
[[nodiscard]] double lateral_sd_px(double angle_rad);

/// Khoshelham and Elberink: depth step z^2 / (f b) of one disparity step.
[[nodiscard]] double depth_step_mm(double z_mm);

}  // namespace kinect

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
