// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/far_view.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {

FarView::FarView(const Eigen::AlignedBox3f& bounds,
                 const Eigen::Vector3d& from,
                 int width,
                 int height) {
  using Eigen::Vector3d;
  constexpr double kFar = 12.0;  // Body sizes.
  constexpr double kRoom = 1.06;
  const Vector3d center = bounds.center().cast<double>();
  const double size_mm = std::max(1.0, static_cast<double>(bounds.diagonal().norm()));
  const Vector3d up = std::abs(from.z()) < 0.99 ? Vector3d(0, 0, 1) : Vector3d(0, -1, 0);
  Eigen::Matrix3d ct_from_view;
  ct_from_view.col(2) = -from;
  ct_from_view.col(0) = (-from).cross(up).normalized();
  ct_from_view.col(1) = ct_from_view.col(2).cross(ct_from_view.col(0));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = ct_from_view;
  pose.translation() = center + kFar * size_mm * from;
  view_from_ct = pose.inverse();
  // The box's corners just fit.
  double reach_x = 1e-6;
  double reach_y = 1e-6;
  for (int corner = 0; corner < 8; ++corner) {
    const auto which = static_cast<Eigen::AlignedBox3f::CornerType>(corner);
    const Vector3d p = view_from_ct * bounds.corner(which).cast<double>();
    reach_x = std::max(reach_x, std::abs(p.x() / p.z()));
    reach_y = std::max(reach_y, std::abs(p.y() / p.z()));
  }
  const double focal_px = std::min(0.5 * width / reach_x, 0.5 * height / reach_y) / kRoom;
  camera = {.width_px = width,
            .height_px = height,
            .focal_x_px = focal_px,
            .focal_y_px = focal_px,
            .center_x_px = 0.5 * (width - 1),
            .center_y_px = 0.5 * (height - 1)};
}

}  // namespace mor::internal
