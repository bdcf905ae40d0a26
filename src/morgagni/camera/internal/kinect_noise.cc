// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/kinect_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Core>

namespace mor::internal {
namespace {

/// Nguyen et al. measured up to about 80 degrees; beyond, readings go missing.
constexpr double kDropFromRad = 70.0 * std::numbers::pi / 180.0;
constexpr double kDropAllRad = 86.0 * std::numbers::pi / 180.0;
/// A neighbour farther away than this share of the depth makes an edge.
constexpr float kEdgeShare = 0.03F;
constexpr std::uint32_t kDropAtEdge = 36000;  // Of 65536.
constexpr std::uint32_t kDropAnywhere = 40;   // Of 65536: speckle that found no match.

/// Disparity in steps times depth: Khoshelham and Elberink's f b, in steps and mm.
constexpr double kStepsTimesMm =
    kinect::kInfraredFocalPx * kinect::kBaselineMm / kinect::kDisparityStepPx;

/// Nearer than 170 mm there is nothing to see, and nothing casts a shadow.
constexpr float kTooNearSteps = 2048.0F;

/// The measured noise holds that of the disparity's steps and of whole millimetres. Both come by
/// themselves afterwards (an even step adds step^2 / 12), so they are taken out here.
float axial_rest_sd_mm(double z_mm, double angle_rad) {
  const double sd_mm = kinect::axial_sd_mm(z_mm, angle_rad);
  const double step_mm = kinect::depth_step_mm(z_mm);
  const double rest_mm2 = sd_mm * sd_mm - (step_mm * step_mm + 1.0) / 12.0;
  return static_cast<float>(std::sqrt(std::max(rest_mm2, 0.0)));
}

}  // namespace

KinectNoise::KinectNoise(double focal_px, std::uint64_t seed)
    : focal_px_(focal_px), seed_(seed), by_angle_(kNumAngles), depth_of_step_mm_(kNumSteps, 0) {
  for (std::size_t i = 0; i < kNumAngles; ++i) {
    const double cosine = std::min(1.0, (4.0 * static_cast<double>(i) + 2.0) / 253.0);
    const double angle_rad = std::min(std::acos(cosine), kDropAllRad);
    auto& angle = by_angle_[i];
    const double share =
        std::clamp((angle_rad - kDropFromRad) / (kDropAllRad - kDropFromRad), 0.0, 1.0);
    angle.drop_below = std::max(kDropAnywhere, static_cast<std::uint32_t>(share * share * 65536.0));
    for (std::size_t k = 0; k < angle.shift_px.size(); ++k) {
      const double shift_px = kinect::lateral_sd_px(angle_rad) * normal_(16 * k + 8);
      angle.shift_px[k] =
          static_cast<std::int8_t>(std::clamp<long>(std::lrint(shift_px), -kRimPx, kRimPx));
    }
    for (std::size_t k = 0; k < angle.sd_steps.size(); ++k) {
      const double z_mm = kStepsTimesMm / (2.0 * static_cast<double>(k) + 1.0);
      angle.sd_steps[k] =
          axial_rest_sd_mm(z_mm, angle_rad) / static_cast<float>(kinect::depth_step_mm(z_mm));
    }
  }
  for (std::size_t i = 1; i < kNumSteps; ++i) {
    const double z_mm = kStepsTimesMm / static_cast<double>(i);
    if (z_mm < kinect::kNearestMm || z_mm > kinect::kFarthestMm) continue;
    depth_of_step_mm_[i] = static_cast<std::uint16_t>(std::lround(z_mm));
  }
}

/// The projector stands to the right: from there, what the camera sees lies at column x - f b / z.
/// Columns must fall from right to left; where one does not, something on its right hides it.
void KinectNoise::mark_shadow(const float* steps, int width, std::uint8_t* is_lit) const {
  const auto px_per_step = static_cast<float>(focal_px_ * kinect::kBaselineMm / kStepsTimesMm);
  float leftmost = std::numeric_limits<float>::infinity();
  for (int x = width - 1; x >= 0; --x) {
    is_lit[x] = 0;
    if (steps[x] >= kTooNearSteps) continue;
    const float column = static_cast<float>(x) - px_per_step * steps[x];
    if (column > leftmost) continue;
    is_lit[x] = 1;
    leftmost = column;
  }
}

std::uint16_t KinectNoise::measure(float steps, const ByAngle& angle, std::uint64_t bits) const {
  constexpr auto kMost = static_cast<float>(kNumSteps - 1);
  const auto disparity_class = static_cast<std::size_t>(0.5F * std::min(steps, kMost));
  const float noisy = steps + angle.sd_steps[disparity_class] * normal_(bits);
  return depth_of_step_mm_[static_cast<std::size_t>(std::clamp(noisy + 0.5F, 0.0F, kMost))];
}

/// Disparity in steps, with a rim that repeats the outermost pixels, so that a look beside a pixel
/// needs no test. What is nothing becomes too near to be seen.
Image<float> KinectNoise::disparity_with_rim(const Image<float>& depth_mm) {
  const int width = depth_mm.width();
  Image<float> steps(width + 2 * kRimPx, depth_mm.height() + 2 * kRimPx);
  for (int y = 0; y < steps.height(); ++y) {
    const float* z_mm = depth_mm.view().row(std::clamp(y - kRimPx, 0, depth_mm.height() - 1));
    float* row = steps.view().row(y);
    Eigen::Map<Eigen::ArrayXf>(row + kRimPx, width) =
        static_cast<float>(kStepsTimesMm) *
        Eigen::Map<const Eigen::ArrayXf>(z_mm, width).max(1.0F).inverse();
    std::fill_n(row, kRimPx, row[kRimPx]);
    std::fill_n(row + kRimPx + width, kRimPx, row[kRimPx + width - 1]);
  }
  return steps;
}

Image<std::uint16_t> KinectNoise::apply(const IdealDepth& ideal, std::uint64_t frame_id) const {
  const int width = ideal.z_mm.width();
  const int height = ideal.z_mm.height();
  const Image<float> disparity = disparity_with_rim(ideal.z_mm);
  const int stride = disparity.width();
  Image<std::uint16_t> seen(width, height, 0);
  std::vector<std::uint8_t> is_lit(static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    const float* row = disparity.view().row(y + kRimPx) + kRimPx;
    const std::uint8_t* facing = ideal.facing.view().row(y);
    std::uint16_t* seen_row = seen.view().row(y);
    mark_shadow(row, width, is_lit.data());
    RowRandom random(seed_, frame_id, static_cast<std::uint64_t>(y));
    for (int x = 0; x < width; ++x) {
      const std::uint64_t bits = random.next();
      if (is_lit[static_cast<std::size_t>(x)] == 0) continue;
      const auto& angle = by_angle_[facing[x] / 4U];
      // Lateral noise: the reading belongs to a place beside the pixel.
      const int shift_x = angle.shift_px[bits & 255U];
      const int shift_y = angle.shift_px[(bits >> 8U) & 255U];
      const float steps = row[x + shift_x + shift_y * stride];
      const bool is_edge = std::abs(steps - row[x]) > kEdgeShare * row[x];
      const auto drop_below = is_edge ? std::max(kDropAtEdge, angle.drop_below) : angle.drop_below;
      if ((bits >> 48U) >= drop_below) seen_row[x] = measure(steps, angle, bits >> 20U);
    }
  }
  return seen;
}

}  // namespace mor::internal
