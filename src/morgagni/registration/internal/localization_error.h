// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// How well the camera knows where a point is: covariance s I + a a^T, larger along the viewing
/// ray. mm^2 and mm, in the camera's frame; a rotation R turns it into s I + (R a)(R a)^T.
struct SensorError {
  Eigen::Vector3f along_ray_mm;
  float sideways_mm2;
};

/// How well a vertex stands for its piece of the skin: covariance s I - a a^T, small along the
/// normal, as wide as the triangles are along the surface.
struct SkinError {
  Eigen::Vector3f along_normal_mm;
  float sideways_mm2;
};

/// Of a Kinect: the axial noise of Nguyen et al. 2012 along the ray, their 0.8 pixels across it.
/// @param points  mm, in the camera's frame: the camera is at its origin.
[[nodiscard]] std::vector<SensorError> sensor_errors(std::span<const Eigen::Vector3f> points);

/// From the vertices around each: along the surface their spread, along the normal the relief.
/// Maier-Hein et al. 2012 take both from such a neighbourhood (their CM_PCA).
/// @param mesh  With normals.
[[nodiscard]] std::vector<SkinError> skin_errors(const TriangleMesh& mesh);

}  // namespace mor::internal
