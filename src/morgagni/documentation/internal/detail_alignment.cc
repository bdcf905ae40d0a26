// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/detail_alignment.h"

#include <algorithm>
#include <cmath>

#include "morgagni/geometry/rigid.h"

namespace mor::internal {
namespace {

using Eigen::Vector3f;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr int kIterations = 6;
constexpr std::size_t kFewDetails = 300;
constexpr double kLevelSd = 4.0;    ///< Of a difference: grain, sampling, shading.
constexpr double kTogether = 40.0;  ///< Neighbouring texels err together.
constexpr double kLeverMm = 120.0;  ///< What a turn moves the skin by, a radian.

float brightness(const Vector3f& color) {
  return 0.3F * color.x() + 0.59F * color.y() + 0.11F * color.z();
}

/// What the frame shows at a place, above or below its surroundings.
float detail_at(const FrameLook& frame, const SkinSight& sight, float gain) {
  const Eigen::Vector4f soft = frame.soft_color(sight);
  return gain * (brightness(frame.color(sight)) - brightness(soft.head<3>()));
}

struct NormalEquations {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d right = Vector6d::Zero();
  double cost = 0.0;
  double shift_mm = 0.0;
  std::size_t count = 0;
};

/// @param pivot  In the colour camera's frame: about it the pose turns.
NormalEquations equations(const FrameLook& frame,
                          const std::vector<KnownDetail>& details,
                          const Vector3f& pivot,
                          float gain) {
  NormalEquations sums;
  const auto& camera = frame.camera();
  for (const auto& detail : details) {
    const auto sight = frame.sight(detail.at_mm, detail.normal);
    if (!sight || frame.soft_color(*sight).w() < 0.35F) continue;
    const auto value_at = [&](float dx, float dy) {
      SkinSight moved = *sight;
      moved.color_px += Eigen::Vector2f(dx, dy);
      return gain * brightness(frame.color(moved));
    };
    const float slope_x = 0.5F * (value_at(1, 0) - value_at(-1, 0));
    const float slope_y = 0.5F * (value_at(0, 1) - value_at(0, -1));
    const double difference =
        static_cast<double>(detail_at(frame, *sight, gain) - detail.brightness);
    const Vector3f p = frame.color_from_ct() * detail.at_mm;
    const double inverse_z = 1.0 / static_cast<double>(p.z());
    const double per_x = static_cast<double>(slope_x) * camera.focal_x_px * inverse_z;
    const double per_y = static_cast<double>(slope_y) * camera.focal_y_px * inverse_z;
    const Eigen::Vector3d per_mm(
        per_x,
        per_y,
        -(per_x * static_cast<double>(p.x()) + per_y * static_cast<double>(p.y())) * inverse_z);
    Vector6d row;
    row << (p - pivot).cast<double>().cross(per_mm), per_mm;
    // Huber: what differs by more than noise does is half believed.
    const double size = std::abs(difference);
    const double weight = size <= 2.0 * kLevelSd ? 1.0 : 2.0 * kLevelSd / size;
    sums.matrix += weight * row * row.transpose();
    sums.right -= weight * difference * row;
    ++sums.count;
  }
  const double information = 1.0 / (kLevelSd * kLevelSd * kTogether);
  sums.matrix *= information;
  sums.right *= information;
  return sums;
}

}  // namespace

std::optional<DetailAlignment> align_details(FrameLook& frame,
                                             const std::vector<KnownDetail>& details,
                                             const Eigen::Isometry3d& color_from_ct,
                                             float gain,
                                             double pose_sd_mm) {
  Vector3f middle = Vector3f::Zero();
  std::size_t count = 0;
  for (const auto& detail : details) {
    if (!frame.sight(detail.at_mm, detail.normal)) continue;
    middle += detail.at_mm;
    ++count;
  }
  if (count < kFewDetails) return std::nullopt;
  middle /= static_cast<float>(count);
  DetailAlignment result{color_from_ct, 0.0};
  Vector6d prior;
  prior << Vector6d::Constant(1.0 / (pose_sd_mm * pose_sd_mm));
  prior.head<3>() *= kLeverMm * kLeverMm;
  Vector6d total = Vector6d::Zero();
  for (int i = 0; i < kIterations; ++i) {
    frame.move_to(result.color_from_ct);
    const Vector3f pivot = frame.color_from_ct() * middle;
    auto sums = equations(frame, details, pivot, gain);
    if (sums.count < kFewDetails) {
      frame.move_to(color_from_ct);
      return std::nullopt;
    }
    sums.matrix.diagonal() += prior;
    sums.right -= prior.cwiseProduct(total);
    const Vector6d step = sums.matrix.ldlt().solve(sums.right);
    total += step;
    const Eigen::Translation3d to_pivot(pivot.cast<double>());
    result.color_from_ct =
        orthonormalized(Eigen::Isometry3d(to_pivot) * se3_exp(step) *
                        Eigen::Isometry3d(to_pivot.inverse()) * result.color_from_ct);
    if (step.head<3>().norm() * kLeverMm + step.tail<3>().norm() < 0.02) break;
  }
  frame.move_to(result.color_from_ct);
  result.shift_mm = displacement_mm(result.color_from_ct, color_from_ct, middle.cast<double>());
  return result;
}

}  // namespace mor::internal
