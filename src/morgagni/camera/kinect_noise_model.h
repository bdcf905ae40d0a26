// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The Kinect v1 as measured by Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise for improved
/// 3D reconstruction and tracking", 3DIMPVT 2012 (axial and lateral noise), and by Khoshelham and
/// Elberink, "Accuracy and resolution of Kinect depth data", Sensors 12, 2012 (disparity steps).
namespace mor::kinect {

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

}  // namespace mor::kinect
