// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/geometry/point_cloud.h"
#include "morgagni/registration/fixed_surface.h"

namespace mor::internal {

/// A body without any symmetry for tests: an ellipsoid of 240 x 160 x 300 mm with bumps, closed,
/// about 2 * rings^2 triangles, centred at `center`.
[[nodiscard]] TriangleMesh bumpy_body(int rings, const Eigen::Vector3f& center);

/// The same with its field.
[[nodiscard]] std::shared_ptr<const FixedSurface> bumpy_surface(int rings = 120);

/// What a camera at `mesh_from_camera` sees of a mesh: points and normals in the camera's frame.
[[nodiscard]] PointCloud seen_by_camera(const TriangleMesh& mesh,
                                        const Eigen::Isometry3d& mesh_from_camera);

/// A camera 600 mm in front of the body made by `bumpy_surface`, a little to the side.
[[nodiscard]] Eigen::Isometry3d camera_before_body();

/// The rotation about `axis` through `pivot`, then the shift.
[[nodiscard]] Eigen::Isometry3d motion_about(const Eigen::Vector3d& pivot,
                                             const Eigen::Vector3d& axis,
                                             double angle_rad,
                                             const Eigen::Vector3d& shift_mm);

}  // namespace mor::internal
