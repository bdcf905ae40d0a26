// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/localization_error.h"

#include <algorithm>
#include <cmath>

#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

/// Nguyen et al. 2012: 0.8 pixels across the ray, here of a Kinect's focal length of 575 pixels.
constexpr float kSidewaysPerDepth = 0.8F / 575.0F;
constexpr float kMinSidewaysMm = 0.1F;
/// Of the skin along its normal: half a voxel of the CT and what remeshing adds.
constexpr float kSkinNormalMm = 0.5F;

/// What the neighbours of a vertex say, before it is divided by their number.
struct Neighborhood {
  float along_surface_mm2 = 0.0F;
  float along_normal_mm2 = 0.0F;
  int num_edges = 0;
};

}  // namespace

std::vector<SensorError> sensor_errors(std::span<const Eigen::Vector3f> points) {
  std::vector<SensorError> errors;
  errors.reserve(points.size());
  for (const auto& point : points) {
    const float depth_mm = std::max(0.0F, point.z());
    const float axial_mm = axial_noise_mm(depth_mm);
    const float sideways_mm =
        std::min(axial_mm, std::max(kMinSidewaysMm, kSidewaysPerDepth * depth_mm));
    const float along_mm = std::sqrt(axial_mm * axial_mm - sideways_mm * sideways_mm);
    errors.push_back({along_mm * point.stableNormalized(), sideways_mm * sideways_mm});
  }
  return errors;
}

std::vector<SkinError> skin_errors(const TriangleMesh& mesh) {
  std::vector<Neighborhood> around(mesh.vertices.size());
  const auto add_edge = [&](std::uint32_t from, std::uint32_t to) {
    const Eigen::Vector3f edge = mesh.vertices[to] - mesh.vertices[from];
    const float height_mm = mesh.normals[from].dot(edge);
    around[from].along_surface_mm2 += edge.squaredNorm() - height_mm * height_mm;
    around[from].along_normal_mm2 += height_mm * height_mm;
    ++around[from].num_edges;
  };
  for (const auto& corners : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      add_edge(corners[i], corners[(i + 1) % 3]);
      add_edge(corners[i], corners[(i + 2) % 3]);
    }
  }
  std::vector<SkinError> errors;
  errors.reserve(around.size());
  for (std::size_t i = 0; i < around.size(); ++i) {
    const auto num_edges = static_cast<float>(std::max(1, around[i].num_edges));
    const float normal_mm2 = kSkinNormalMm * kSkinNormalMm + around[i].along_normal_mm2 / num_edges;
    // Neighbours at a distance h all around have a variance of h^2 / 2 along either axis.
    const float sideways_mm2 = std::max(normal_mm2, 0.5F * around[i].along_surface_mm2 / num_edges);
    errors.push_back({std::sqrt(sideways_mm2 - normal_mm2) * mesh.normals[i], sideways_mm2});
  }
  return errors;
}

}  // namespace mor::internal
