// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/pinhole_camera.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

constexpr int kMaxSidePx = 16384;
constexpr double kNearestMm = 1e-3;
constexpr int kUndistortIterations = 20;

Eigen::Vector2d distort(const Eigen::Vector2d& ray, const std::array<double, 5>& d) {
  const double x = ray.x();
  const double y = ray.y();
  const double r2 = ray.squaredNorm();
  const double radial = 1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  return {x * radial + 2.0 * d[2] * x * y + d[3] * (r2 + 2.0 * x * x),
          y * radial + d[2] * (r2 + 2.0 * y * y) + 2.0 * d[3] * x * y};
}

}  // namespace

Result<void> PinholeCamera::check() const {
  if (width_px < 1 || height_px < 1 || width_px > kMaxSidePx || height_px > kMaxSidePx) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("a camera picture must be 1 to {} px wide and high, got {} x {}",
                                  kMaxSidePx,
                                  width_px,
                                  height_px));
  }
  const bool focal_is_good = std::isfinite(focal_x_px) && std::isfinite(focal_y_px) &&
                             focal_x_px > 0.0 && focal_y_px > 0.0;
  if (!focal_is_good || !std::isfinite(center_x_px) || !std::isfinite(center_y_px)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("a camera needs positive focal lengths and a finite centre, got "
                                  "f = ({}, {}) px, c = ({}, {}) px",
                                  focal_x_px,
                                  focal_y_px,
                                  center_x_px,
                                  center_y_px));
  }
  if (!std::all_of(
          distortion.begin(), distortion.end(), [](double k) { return std::isfinite(k); })) {
    return make_error(ErrorCode::kInvalidArgument, "a camera's distortion must be finite numbers");
  }
  return {};
}

bool PinholeCamera::has_distortion() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

std::optional<Eigen::Vector2d> PinholeCamera::project(const Eigen::Vector3d& point) const {
  if (!(point.z() > kNearestMm)) return std::nullopt;
  const Eigen::Vector2d seen = distort(point.head<2>() / point.z(), distortion);
  return Eigen::Vector2d(focal_x_px * seen.x() + center_x_px, focal_y_px * seen.y() + center_y_px);
}

Eigen::Vector2d PinholeCamera::ray(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d seen((pixel.x() - center_x_px) / focal_x_px,
                             (pixel.y() - center_y_px) / focal_y_px);
  Eigen::Vector2d ray = seen;
  if (!has_distortion()) return ray;
  for (int i = 0; i < kUndistortIterations; ++i) ray += seen - distort(ray, distortion);
  return ray;
}

PinholeCamera PinholeCamera::scaled(double factor) const {
  PinholeCamera result = *this;
  result.width_px = static_cast<int>(std::lround(width_px * factor));
  result.height_px = static_cast<int>(std::lround(height_px * factor));
  result.focal_x_px *= factor;
  result.focal_y_px *= factor;
  // Pixel centres are at whole numbers, so the picture's corner is at (-0.5, -0.5).
  result.center_x_px = (center_x_px + 0.5) * factor - 0.5;
  result.center_y_px = (center_y_px + 0.5) * factor - 0.5;
  return result;
}

}  // namespace mor
