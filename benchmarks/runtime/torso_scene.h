// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/geometry/depth_raster.h"

namespace mor {

/// A torso-sized body (400 x 240 x 600 mm, about 40,000 triangles) with ribs and bumps, on no
/// table: what the benchmarks of depth and registration look at, without any file.
inline TriangleMesh torso_mesh() {
  constexpr int kRings = 140;
  TriangleMesh mesh;
  const auto at = [](int ring, int column) {
    return static_cast<std::uint32_t>(ring * kRings + column % kRings);
  };
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int column = 0; column < kRings; ++column) {
      const double along = std::numbers::pi * (0.02 + 0.96 * ring / kRings);
      const double around = 2.0 * std::numbers::pi * column / kRings;
      const double ribs = 1.0 + 0.03 * std::sin(9.0 * along + 1.0) * std::cos(around - 0.4) +
                          0.05 * std::sin(3.0 * around + 2.0 * along);
      mesh.vertices.emplace_back(200.0 * ribs * std::sin(along) * std::cos(around),
                                 120.0 * ribs * std::sin(along) * std::sin(around),
                                 300.0 * std::cos(along));
      if (ring == kRings) continue;
      mesh.triangles.push_back({at(ring, column), at(ring + 1, column), at(ring, column + 1)});
      mesh.triangles.push_back(
          {at(ring, column + 1), at(ring + 1, column), at(ring + 1, column + 1)});
    }
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

inline PinholeCamera torso_camera() {
  return {640, 480, 525.0, 525.0, 319.5, 239.5, {}};
}

/// The camera 750 mm in front of the torso's middle.
inline Eigen::Isometry3d torso_from_camera() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = Eigen::Vector3d::UnitX();
  pose.linear().col(1) = -Eigen::Vector3d::UnitZ();
  pose.linear().col(2) = Eigen::Vector3d::UnitY();
  pose.translation() = Eigen::Vector3d(0.0, -750.0, 0.0);
  return pose;
}

/// The torso's depth image with a Kinect's axial noise, whole millimetres.
inline Image<std::uint16_t> torso_depth(const TriangleMesh& mesh) {
  const DepthRaster raster = rasterize_depth(mesh, torso_camera(), torso_from_camera().inverse());
  Image<std::uint16_t> depth(raster.depth_mm.width(), raster.depth_mm.height());
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, 1.4F);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const float z = raster.depth_mm.data()[i];
    if (z > 0.0F) depth.data()[i] = static_cast<std::uint16_t>(std::lround(z + noise(random)));
  }
  return depth;
}

}  // namespace mor
