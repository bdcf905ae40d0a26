// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Places of the skin that face a camera, evenly taken from all: where its depth picture shows the
/// body when its pose is about known. Those at the far side and at the open ends of the CT are none
/// of them; what hides them from the camera is not looked at.
/// @param skin  With normals. @return At most 300, frame depth, mm; empty where nothing faces it.
/// @cost About 0.03 ms: looks at 2000 vertices at most.
[[nodiscard]] std::vector<Eigen::Vector3d> places_facing_camera(
    const TriangleMesh& skin, const Eigen::Isometry3d& ct_from_depth);

}  // namespace mor
