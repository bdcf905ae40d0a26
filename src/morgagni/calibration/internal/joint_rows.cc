// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/joint_rows.h"

#include <Eigen/LU>

namespace mor::internal {
namespace {

constexpr double kNearestMm = 1.0;

/// A distorted ray, and how it changes with the ray and with k1, k2, p1, p2.
struct Distorted {
  Eigen::Vector2d at;
  Eigen::Matrix2d by_ray;
  Eigen::Matrix<double, 2, 4> by_distortion;
};

Distorted distort(const Eigen::Vector2d& ray, const std::array<double, 5>& d) {
  const double x = ray.x();
  const double y = ray.y();
  const double r2 = ray.squaredNorm();
  const double radial = 1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  const double by_r2 = d[0] + r2 * (2.0 * d[1] + 3.0 * r2 * d[4]);
  const double mixed = 2.0 * (x * y * by_r2 + d[2] * x + d[3] * y);
  Distorted result;
  result.at = {x * radial + 2.0 * d[2] * x * y + d[3] * (r2 + 2.0 * x * x),
               y * radial + d[2] * (r2 + 2.0 * y * y) + 2.0 * d[3] * x * y};
  result.by_ray << radial + 2.0 * (x * x * by_r2 + d[2] * y + 3.0 * d[3] * x), mixed, mixed,
      radial + 2.0 * (y * y * by_r2 + 3.0 * d[2] * y + d[3] * x);
  result.by_distortion << x * r2, x * r2 * r2, 2.0 * x * y, r2 + 2.0 * x * x, y * r2, y * r2 * r2,
      r2 + 2.0 * y * y, 2.0 * x * y;
  return result;
}

LensSlopes lens_slopes(const PinholeCamera& camera, const Distorted& distorted) {
  LensSlopes slopes;
  slopes << distorted.at.x(), 0.0, 1.0, 0.0, camera.focal_x_px * distorted.by_distortion.row(0),
      0.0, distorted.at.y(), 0.0, 1.0, camera.focal_y_px * distorted.by_distortion.row(1);
  return slopes;
}

Eigen::Matrix2d ray_slopes(const PinholeCamera& camera, const Distorted& distorted) {
  return Eigen::Vector2d(camera.focal_x_px, camera.focal_y_px).asDiagonal() * distorted.by_ray;
}

}  // namespace

LensVector lens_vector(const PinholeCamera& camera) {
  LensVector values;
  values << camera.focal_x_px, camera.focal_y_px, camera.center_x_px, camera.center_y_px,
      camera.distortion[0], camera.distortion[1], camera.distortion[2], camera.distortion[3];
  return values;
}

void set_lens(const LensVector& values, PinholeCamera& camera) {
  camera.focal_x_px = values[0];
  camera.focal_y_px = values[1];
  camera.center_x_px = values[2];
  camera.center_y_px = values[3];
  for (std::size_t i = 0; i < 4; ++i) {
    camera.distortion[i] = values[4 + static_cast<Eigen::Index>(i)];
  }
}

std::optional<SeenPoint> see(const PinholeCamera& camera, const Eigen::Vector3d& point_mm) {
  if (!(point_mm.z() > kNearestMm)) return std::nullopt;
  const Eigen::Vector2d ray = point_mm.head<2>() / point_mm.z();
  const Distorted distorted = distort(ray, camera.distortion);
  Eigen::Matrix<double, 2, 3> ray_by_point;
  ray_by_point << Eigen::Matrix2d::Identity(), -ray;
  ray_by_point /= point_mm.z();
  SeenPoint seen;
  seen.px = {camera.focal_x_px * distorted.at.x() + camera.center_x_px,
             camera.focal_y_px * distorted.at.y() + camera.center_y_px};
  seen.by_point = ray_slopes(camera, distorted) * ray_by_point;
  seen.by_lens = lens_slopes(camera, distorted);
  return seen;
}

SeenRay ray_of(const PinholeCamera& camera, const Eigen::Vector2d& px) {
  SeenRay seen;
  seen.ray = camera.ray(px);
  const Distorted distorted = distort(seen.ray, camera.distortion);
  // The pixel stays: where the lens moves it, the ray moves against that.
  seen.by_lens = -ray_slopes(camera, distorted).inverse() * lens_slopes(camera, distorted);
  return seen;
}

MetPlane meet(const Eigen::Vector2d& ray,
              const Eigen::Vector3d& normal,
              const Eigen::Vector3d& on_plane) {
  const Eigen::Vector3d along = ray.homogeneous();
  const double slant = normal.dot(along);
  MetPlane met;
  met.z_mm = normal.dot(on_plane) / slant;
  met.by_ray = -met.z_mm / slant * normal.head<2>();
  met.by_normal = (on_plane - met.z_mm * along) / slant;
  met.by_turn = normal.cross(met.by_normal);
  met.by_shift = normal / slant;
  return met;
}

void move(const Eigen::Vector3d& turn_rad,
          const Eigen::Vector3d& shift_mm,
          const Eigen::Vector3d& pivot_mm,
          Eigen::Isometry3d& pose) {
  const double angle = turn_rad.norm();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translate(pivot_mm + shift_mm);
  if (angle > 0.0) motion.rotate(Eigen::AngleAxisd(angle, turn_rad / angle));
  motion.translate(-pivot_mm);
  pose = motion * pose;
}

}  // namespace mor::internal
