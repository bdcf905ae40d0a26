// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/kinect_noise_model.h"

#include <cmath>
#include <numbers>

namespace mor::kinect {
namespace {

double angle_share(double angle_rad) {
  return angle_rad / (std::numbers::pi / 2.0 - angle_rad);
}

}  // namespace

double axial_sd_mm(double z_mm, double angle_rad) {
  const double z_m = z_mm / 1000.0;
  const double head_on_m = 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4);
  const double tilted_m = 0.0001 / std::sqrt(z_m) * angle_share(angle_rad) * angle_share(angle_rad);
  return 1000.0 * (head_on_m + tilted_m);
}

double lateral_sd_px(double angle_rad) {
  return 0.8 + 0.035 * angle_share(angle_rad);
}

double depth_step_mm(double z_mm) {
  return z_mm * z_mm * kDisparityStepPx / (kInfraredFocalPx * kBaselineMm);
}

}  // namespace mor::kinect
