// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/visible_place.h"

namespace mor {
namespace {

constexpr std::size_t kMaxVertices = 2000;
constexpr std::size_t kMaxPlaces = 300;
constexpr double kFacingCosine = 0.5;

}  // namespace

std::vector<Eigen::Vector3d> places_facing_camera(const TriangleMesh& skin,
                                                  const Eigen::Isometry3d& ct_from_depth) {
  const Eigen::Isometry3d depth_from_ct = ct_from_depth.inverse();
  std::vector<Eigen::Vector3d> facing;
  const std::size_t stride = skin.vertices.size() / kMaxVertices + 1;
  for (std::size_t i = 0; i < skin.vertices.size(); i += stride) {
    const Eigen::Vector3d place = depth_from_ct * skin.vertices[i].cast<double>();
    const Eigen::Vector3d normal = depth_from_ct.linear() * skin.normals[i].cast<double>();
    if (place.z() > 0.0 && -normal.dot(place) > kFacingCosine * place.norm()) {
      facing.push_back(place);
    }
  }
  const std::size_t keep_each = facing.size() / kMaxPlaces + 1;
  std::vector<Eigen::Vector3d> places;
  for (std::size_t i = 0; i < facing.size(); i += keep_each) places.push_back(facing[i]);
  return places;
}

}  // namespace mor
