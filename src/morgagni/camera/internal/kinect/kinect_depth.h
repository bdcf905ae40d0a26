// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "morgagni/camera/range_camera.h"

namespace mor::internal {

inline constexpr int kKinectWidthPx = 640;
inline constexpr int kKinectHeightPx = 480;
inline constexpr std::size_t kKinectPixels = std::size_t{640} * 480;
/// Raw depth has 11 bits; this value means that there is no reading.
inline constexpr std::uint16_t kKinectNoReading = 2047;

/// The geometry of one Kinect for Xbox 360, as its memory gives it. The values here are those that
/// all devices were built for.
struct KinectGeometry {
  double reference_distance_mm = 1200.0;  ///< At it a dot has disparity 0.
  double reference_pixel_mm = 0.1042;     ///< Of the sensor, two by two, seen from 120 mm.
  double emitter_distance_mm = 75.0;      ///< Infrared camera to projector.
  double color_distance_mm = 23.0;        ///< Infrared camera to colour camera.
  double raw_at_reference = 800.0;        ///< Four times the constant shift.

  /// @errors kInvalidArgument: a value that no Kinect has.
  [[nodiscard]] Result<void> check() const;
};

/// Millimetres of each raw value by triangulation, 0 where there is none.
[[nodiscard]] std::array<std::uint16_t, 2048> kinect_mm_from_raw(const KinectGeometry& geometry);

/// A calibration to begin with: focal lengths of the design (575.8 px infrared, 525 px colour), the
/// cameras side by side and parallel. A calibrated device is centimetres better at the picture's
/// edge.
[[nodiscard]] RgbdCalibration kinect_calibration(const KinectGeometry& geometry);

}  // namespace mor::internal
