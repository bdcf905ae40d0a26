// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/kinect/kinect_depth.h"

#include <cmath>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr double kRawPerPixel = 4.0;  // The last of them are quarters: sub-pixel disparity.
constexpr double kRawOffset = 0.375;
constexpr double kReferenceSensorMm = 120.0;  // Distance at which `reference_pixel_mm` is seen.
constexpr double kMaxMm = 10000.0;
constexpr double kColorFocalPx = 525.0;

bool is_near(double value, double expected) {
  return value > 0.5 * expected && value < 2.0 * expected;
}

PinholeCamera pinhole(double focal_px) {
  return {.width_px = kKinectWidthPx,
          .height_px = kKinectHeightPx,
          .focal_x_px = focal_px,
          .focal_y_px = focal_px,
          .center_x_px = (kKinectWidthPx - 1) / 2.0,
          .center_y_px = (kKinectHeightPx - 1) / 2.0};
}

}  // namespace

Result<void> KinectGeometry::check() const {
  const KinectGeometry design;
  const bool is_possible = is_near(reference_distance_mm, design.reference_distance_mm) &&
                           is_near(reference_pixel_mm, design.reference_pixel_mm) &&
                           is_near(emitter_distance_mm, design.emitter_distance_mm) &&
                           is_near(color_distance_mm, design.color_distance_mm) &&
                           is_near(raw_at_reference, design.raw_at_reference);
  if (is_possible) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("the Kinect's memory holds values that no Kinect has (reference {} mm, pixel {} "
                  "mm, emitter {} mm, colour {} mm, shift {})",
                  reference_distance_mm,
                  reference_pixel_mm,
                  emitter_distance_mm,
                  color_distance_mm,
                  raw_at_reference));
}

/// Disparity d on the sensor against the reference plane at distance Z0, base line b: similar
/// triangles give z = Z0 + Z0 d / (b - d), with d in the measure of b.
std::array<std::uint16_t, 2048> kinect_mm_from_raw(const KinectGeometry& geometry) {
  std::array<std::uint16_t, 2048> mm{};
  // What one pixel's shift means across the base line, at the reference plane.
  const double scale = geometry.reference_distance_mm / kReferenceSensorMm;
  for (std::size_t raw = 0; raw < kKinectNoReading; ++raw) {
    const double pixels =
        (static_cast<double>(raw) - geometry.raw_at_reference) / kRawPerPixel - kRawOffset;
    const double shift_mm = pixels * geometry.reference_pixel_mm * scale;
    if (shift_mm >= geometry.emitter_distance_mm) continue;
    const double z_mm = geometry.reference_distance_mm *
                        (1.0 + shift_mm / (geometry.emitter_distance_mm - shift_mm));
    if (z_mm > 0.0 && z_mm <= kMaxMm) mm[raw] = static_cast<std::uint16_t>(std::lround(z_mm));
  }
  return mm;
}

RgbdCalibration kinect_calibration(const KinectGeometry& geometry) {
  // A sensor pixel of the full picture is half as large as the reference pixel.
  RgbdCalibration calibration{pinhole(kReferenceSensorMm / geometry.reference_pixel_mm / 2.0),
                              pinhole(kColorFocalPx),
                              Eigen::Isometry3d::Identity()};
  // Seen from behind, the colour camera is to the right of the infrared one.
  calibration.color_from_depth.translation().x() = -geometry.color_distance_mm;
  return calibration;
}

}  // namespace mor::internal
