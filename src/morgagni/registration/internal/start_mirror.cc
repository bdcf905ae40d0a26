// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_mirror.h"

#include <utility>

namespace mor::internal {

StartPicture mirrored(const StartPicture& picture) {
  StartPicture other = picture;
  const int last = picture.z_mm.width() - 1;
  for (int y = 0; y < picture.z_mm.height(); ++y) {
    for (int x = 0; x <= last; ++x) other.z_mm(x, y) = picture.z_mm(last - x, y);
  }
  other.even_mm = evened(other.z_mm);
  other.camera.center_x_px = last - picture.camera.center_x_px;
  return other;
}

std::vector<StartPlane> mirrored(std::vector<StartPlane> planes) {
  for (auto& plane : planes) plane.normal.x() = -plane.normal.x();
  return planes;
}

PointCloud mirrored(PointCloud cloud) {
  for (auto& point : cloud.points) point.x() = -point.x();
  for (auto& normal : cloud.normals) normal.x() = -normal.x();
  return cloud;
}

Eigen::Isometry3d mirrored(const Eigen::Isometry3d& ct_from_depth,
                           const Eigen::Vector3d& middle_ct) {
  Eigen::Isometry3d other = ct_from_depth;
  // Reflected on both sides: a pose again.
  other.linear().row(0) *= -1.0;
  other.linear().col(0) *= -1.0;
  other.translation().x() = 2.0 * middle_ct.x() - ct_from_depth.translation().x();
  return other;
}

SeenViews mirrored(const SeenViews& views) {
  std::vector<SeenView> others;
  for (const auto& view : views.all()) {
    others.push_back({mirrored(view.own),
                      mirrored(view.picture),
                      mirrored(view.planes),
                      mirrored(view.standing),
                      mirrored(view.newest_from_this, Eigen::Vector3d::Zero()),
                      view.age});
  }
  return SeenViews(std::move(others));
}

}  // namespace mor::internal
