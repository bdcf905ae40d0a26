// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/kinect_noise.h"

#include <algorithm>
#include <limits>

namespace mor::internal {
namespace {

constexpr double kRightAngleRad = std::numbers::pi / 2.0;
/// Nguyen et al. measured up to about 80 degrees; beyond, readings go missing.
constexpr double kDropFromRad = 70.0 * std::numbers::pi / 180.0;
constexpr double kDropAllRad = 86.0 * std::numbers::pi / 180.0;
/// A neighbour farther away than this share of the depth makes an edge.
constexpr float kEdgeShare = 0.03F;
constexpr std::uint32_t kDropAtEdge = 36000;  // Of 65536.
constexpr std::uint32_t kDropAnywhere = 40;   // Of 65536: speckle that found no match.

double angle_share(double angle_rad) {
  return angle_rad / (kRightAngleRad - angle_rad);
}

}  // namespace

namespace kinect {

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

}  // namespace kinect

KinectNoise::KinectNoise(double focal_px, std::uint64_t seed) : focal_px_(focal_px), seed_(seed) {
  for (std::size_t i = 0; i < by_facing_.size(); ++i) {
    const double angle_rad = std::min(std::acos(static_cast<double>(i) / 255.0), kDropAllRad);
    const double share =
        std::clamp((angle_rad - kDropFromRad) / (kDropAllRad - kDropFromRad), 0.0, 1.0);
    by_facing_[i] = {static_cast<float>(kinect::lateral_sd_px(angle_rad)),
                     static_cast<float>(kinect::axial_sd_mm(1000.0, angle_rad) -
                                        kinect::axial_sd_mm(1000.0, 0.0)),
                     std::max(kDropAnywhere, static_cast<std::uint32_t>(share * share * 65536.0))};
  }
}

/// The projector stands to the right: from there, what the camera sees lies at column x - f b / z.
/// Columns must fall from right to left; where one does not, something on its right hides it.
void KinectNoise::mark_shadow(const float* z_mm, int width, std::uint8_t* is_lit) const {
  const auto focal_baseline = static_cast<float>(focal_px_ * kinect::kBaselineMm);
  float leftmost = std::numeric_limits<float>::infinity();
  for (int x = width - 1; x >= 0; --x) {
    is_lit[x] = 0;
    if (z_mm[x] <= 0.0F) continue;
    const float column = static_cast<float>(x) - focal_baseline / z_mm[x];
    is_lit[x] = column <= leftmost ? 1 : 0;
    leftmost = std::min(leftmost, column);
  }
}

std::uint16_t KinectNoise::measure(float z_mm, const ByFacing& facing, std::uint64_t bits) const {
  constexpr auto kDisparityMm =
      static_cast<float>(kinect::kInfraredFocalPx * kinect::kBaselineMm / kinect::kDisparityStepPx);
  const float z_m = 0.001F * z_mm;
  const float from_near_m = z_m - 0.4F;
  const float sd_mm =
      1.2F + 1.9F * from_near_m * from_near_m + facing.axial_angle_mm / std::sqrt(z_m);
  // The measured noise holds that of the disparity's steps and of whole millimetres: the steps
  // below add it, so it is taken out here (an even step adds step^2 / 12).
  const float step_mm = z_mm * z_mm / kDisparityMm;
  const float rest_mm2 = sd_mm * sd_mm - (step_mm * step_mm + 1.0F) / 12.0F;
  const float noisy_mm = z_mm + std::sqrt(std::max(rest_mm2, 0.0F)) * normal_(bits);
  const float steps = std::floor(kDisparityMm / noisy_mm + 0.5F);
  const float seen_mm = kDisparityMm / steps;
  if (!(seen_mm >= kinect::kNearestMm && seen_mm <= kinect::kFarthestMm)) return 0;
  return static_cast<std::uint16_t>(seen_mm + 0.5F);
}

Image<std::uint16_t> KinectNoise::apply(const IdealDepth& ideal, std::uint64_t frame_id) const {
  const int width = ideal.z_mm.width();
  const int height = ideal.z_mm.height();
  Image<std::uint16_t> seen(width, height, 0);
  std::vector<std::uint8_t> is_lit(static_cast<std::size_t>(width));
  const auto z_mm = ideal.z_mm.view();
  for (int y = 0; y < height; ++y) {
    mark_shadow(z_mm.row(y), width, is_lit.data());
    RowRandom random(seed_, frame_id, static_cast<std::uint64_t>(y));
    for (int x = 0; x < width; ++x) {
      const std::uint64_t bits = random.next();
      const float here_mm = z_mm(x, y);
      if (here_mm <= 0.0F || is_lit[static_cast<std::size_t>(x)] == 0) continue;
      const auto& facing = by_facing_[ideal.facing(x, y)];
      // Lateral noise: the reading belongs to a place beside the pixel.
      const int from_x =
          std::clamp(x + static_cast<int>(std::lrint(facing.lateral_sd_px * normal_(bits >> 4U))),
                     0,
                     width - 1);
      const int from_y =
          std::clamp(y + static_cast<int>(std::lrint(facing.lateral_sd_px * normal_(bits >> 16U))),
                     0,
                     height - 1);
      const float z = z_mm(from_x, from_y);
      const bool is_edge = std::abs(z - here_mm) > kEdgeShare * here_mm;
      const auto drop_below =
          is_edge ? std::max(kDropAtEdge, facing.drop_below) : facing.drop_below;
      if (z <= 0.0F || (bits >> 48U) < drop_below) continue;
      seen(x, y) = measure(z, facing, bits >> 28U);
    }
  }
  return seen;
}

}  // namespace mor::internal
