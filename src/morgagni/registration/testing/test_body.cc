// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/testing/test_body.h"

#include <cmath>
#include <numbers>

#include "morgagni/geometry/depth_raster.h"

namespace mor::internal {
namespace {

/// The surface in direction `d`: an ellipsoid with four bumps at odd places.
Eigen::Vector3f surface_point(const Eigen::Vector3f& d) {
  const Eigen::Vector3f semi_axes(120.0F, 80.0F, 150.0F);
  const auto bump = [&d](const Eigen::Vector3f& at, float width, float height) {
    return height * std::exp(-(d - at.normalized()).squaredNorm() / (2.0F * width * width));
  };
  const float radius = 1.0F / d.cwiseQuotient(semi_axes).norm();
  return d * (radius + bump({0.2F, -1.0F, 0.3F}, 0.12F, 22.0F) +
              bump({-0.6F, -0.8F, 0.5F}, 0.25F, 15.0F) + bump({0.7F, -0.7F, -0.4F}, 0.2F, 18.0F) +
              bump({-0.3F, -0.9F, -0.7F}, 0.15F, -12.0F));
}

}  // namespace

TriangleMesh bumpy_body(int rings, const Eigen::Vector3f& center) {
  TriangleMesh mesh;
  const int columns = rings;
  const auto direction = [&](int ring, int column) {
    const double polar = std::numbers::pi * ring / rings;
    const double around = 2.0 * std::numbers::pi * column / columns;
    return Eigen::Vector3d(
        std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
  };
  mesh.vertices.push_back(surface_point(Eigen::Vector3f::UnitZ()));
  for (int ring = 1; ring < rings; ++ring) {
    for (int column = 0; column < columns; ++column) {
      mesh.vertices.push_back(surface_point(direction(ring, column).cast<float>()));
    }
  }
  mesh.vertices.push_back(surface_point(-Eigen::Vector3f::UnitZ()));
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const auto at = [&](int ring, int column) {
    if (ring == 0) return std::uint32_t{0};
    if (ring == rings) return last;
    return static_cast<std::uint32_t>(1 + (ring - 1) * columns + column % columns);
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int column = 0; column < columns; ++column) {
      if (ring > 0) {
        mesh.triangles.push_back({at(ring, column), at(ring + 1, column), at(ring, column + 1)});
      }
      if (ring + 1 < rings) {
        mesh.triangles.push_back(
            {at(ring, column + 1), at(ring + 1, column), at(ring + 1, column + 1)});
      }
    }
  }
  for (auto& vertex : mesh.vertices) vertex += center;
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

std::shared_ptr<const FixedSurface> bumpy_surface(int rings) {
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = bumpy_body(rings, {30.0F, -200.0F, 400.0F});
  surface->field = *DistanceField::build(surface->mesh);
  return surface;
}

PointCloud seen_by_camera(const TriangleMesh& mesh, const Eigen::Isometry3d& mesh_from_camera) {
  const PinholeCamera camera{160, 120, 131.0, 131.0, 79.5, 59.5, {}};
  const Eigen::Isometry3d camera_from_mesh = mesh_from_camera.inverse();
  const DepthRaster raster = rasterize_depth(mesh, camera, camera_from_mesh);
  PointCloud cloud;
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const float z = raster.depth_mm(x, y);
      if (z <= 0.0F) continue;
      const Eigen::Vector2f ray = camera.ray({x, y}).cast<float>();
      const auto& [a, b, c] = mesh.triangles[raster.triangle_idx(x, y)];
      const Eigen::Vector3f normal =
          (mesh.normals[a] + mesh.normals[b] + mesh.normals[c]).normalized();
      cloud.points.emplace_back(ray.x() * z, ray.y() * z, z);
      cloud.normals.push_back(camera_from_mesh.linear().cast<float>() * normal);
    }
  }
  return cloud;
}

Eigen::Isometry3d camera_before_body() {
  Eigen::Isometry3d ct_from_depth = Eigen::Isometry3d::Identity();
  ct_from_depth.linear().col(0) = Eigen::Vector3d::UnitX();
  ct_from_depth.linear().col(1) = -Eigen::Vector3d::UnitZ();
  ct_from_depth.linear().col(2) = Eigen::Vector3d::UnitY();
  ct_from_depth.translation() = Eigen::Vector3d(30.0, -200.0 - 680.0, 400.0);
  return motion_about({30.0, -200.0, 400.0}, {1.0, 2.0, 0.5}, 0.3, Eigen::Vector3d::Zero()) *
         ct_from_depth;
}

Eigen::Isometry3d motion_about(const Eigen::Vector3d& pivot,
                               const Eigen::Vector3d& axis,
                               double angle_rad,
                               const Eigen::Vector3d& shift_mm) {
  return Eigen::Isometry3d(Eigen::Translation3d(pivot + shift_mm) *
                           Eigen::AngleAxisd(angle_rad, axis.normalized()) *
                           Eigen::Translation3d(-pivot));
}

}  // namespace mor::internal
