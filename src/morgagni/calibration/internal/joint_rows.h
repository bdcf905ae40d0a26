// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "morgagni/geometry/pinhole_camera.h"

/// What corners and depth readings say of lenses, poses and planes, with their slopes. A pose's
/// step is a rotation about a point and a shift: (turn_rad, shift_mm).
namespace mor::internal {

/// A lens's free numbers: focal lengths, centre, k1, k2, p1, p2.
inline constexpr int kLensSize = 8;
using LensVector = Eigen::Matrix<double, kLensSize, 1>;
using LensSlopes = Eigen::Matrix<double, 2, kLensSize>;

[[nodiscard]] LensVector lens_vector(const PinholeCamera& camera);
void set_lens(const LensVector& values, PinholeCamera& camera);

/// Where a point appears, and how that changes.
struct SeenPoint {
  Eigen::Vector2d px;
  Eigen::Matrix<double, 2, 3> by_point;
  LensSlopes by_lens;
};

/// None: not before the camera.
[[nodiscard]] std::optional<SeenPoint> see(const PinholeCamera& camera,
                                           const Eigen::Vector3d& point_mm);

/// A pixel's ray, and how it changes with the lens.
struct SeenRay {
  Eigen::Vector2d ray;
  LensSlopes by_lens;
};

[[nodiscard]] SeenRay ray_of(const PinholeCamera& camera, const Eigen::Vector2d& px);

/// The depth at which a ray meets a plane, and how that changes.
struct MetPlane {
  double z_mm = 0.0;
  Eigen::Vector2d by_ray;
  Eigen::Vector3d by_normal;
  Eigen::Vector3d by_turn;   ///< Of the plane about `on_plane`.
  Eigen::Vector3d by_shift;  ///< Of the plane.
};

/// @param on_plane  A point of it, mm.
[[nodiscard]] MetPlane meet(const Eigen::Vector2d& ray,
                            const Eigen::Vector3d& normal,
                            const Eigen::Vector3d& on_plane);

/// Moves a pose: turns it about `pivot_mm`, then shifts it.
void move(const Eigen::Vector3d& turn_rad,
          const Eigen::Vector3d& shift_mm,
          const Eigen::Vector3d& pivot_mm,
          Eigen::Isometry3d& pose);

}  // namespace mor::internal
