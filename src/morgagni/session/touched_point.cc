// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/touched_point.h"

#include "morgagni/session/depth_pick.h"

namespace mor {

std::optional<TouchedPoint> touched_point(const TrackedFrame& shown,
                                          const Eigen::Vector2d& color_pixel) {
  const auto point = depth_point_at(*shown.frame, color_pixel);
  if (!point) return std::nullopt;
  TouchedPoint touched{
      .ct_mm = *shown.ct_from_depth * *point, .bound_mm = std::nullopt, .state = shown.state};
  if (shown.covariance) touched.bound_mm = error_bound_mm(*shown.covariance, touched.ct_mm);
  return touched;
}

std::optional<double> bound_at_mm(const TrackedFrame& shown, const Eigen::Vector2d& share) {
  if (!shown.ct_from_depth || !shown.covariance) return std::nullopt;
  const auto& color = shown.frame->calibration->color;
  const auto touched =
      touched_point(shown, {share.x() * color.width_px - 0.5, share.y() * color.height_px - 0.5});
  return touched ? touched->bound_mm : std::nullopt;
}

}  // namespace mor
