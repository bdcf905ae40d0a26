// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_volume.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mor::internal {
namespace {

constexpr int kWorthInside = -50;

/// Out of the body through the side it lies on: LPS.
Eigen::Vector3d down_in_ct(BodySide side) {
  switch (side) {
    case BodySide::kAnterior:
      return -Eigen::Vector3d::UnitY();
    case BodySide::kLeft:
      return Eigen::Vector3d::UnitX();
    case BodySide::kRight:
      return -Eigen::Vector3d::UnitX();
    case BodySide::kPosterior:
      break;
  }
  return Eigen::Vector3d::UnitY();
}

std::int8_t worth_at(float distance_mm, float reach_mm) {
  const float ratio = distance_mm / reach_mm;
  if (ratio >= 1.0F) return 0;
  if (ratio <= -1.0F) return kWorthInside;
  const float rest = 1.0F - ratio * ratio;
  const float on_skin = static_cast<float>(StartVolume::kMostWorth) * rest * rest;
  // Towards the inside it falls below nothing.
  const float inside = ratio < 0.0F ? static_cast<float>(kWorthInside) * ratio * ratio : 0.0F;
  return static_cast<std::int8_t>(std::lround(on_skin + inside));
}

}  // namespace

StartVolume make_start_volume(const FixedSurface& fixed,
                              BodySide lying_on,
                              const StartVolumeOptions& options) {
  StartVolume volume;
  const Eigen::Vector3d up = -down_in_ct(lying_on);
  Eigen::Matrix3d lying_from_ct;
  lying_from_ct.row(1) = Eigen::Vector3d::UnitZ();  // To the head.
  lying_from_ct.row(2) = up;
  lying_from_ct.row(0) = Eigen::Vector3d::UnitZ().cross(up);
  Eigen::AlignedBox3f bounds;
  for (const auto& vertex : fixed.mesh.vertices) {
    bounds.extend((lying_from_ct * vertex.cast<double>()).cast<float>());
  }
  volume.lying_from_ct.linear() = lying_from_ct;
  volume.lying_from_ct.translation() =
      -static_cast<double>(bounds.min().z()) * Eigen::Vector3d::UnitZ();
  bounds.translate(-bounds.min().z() * Eigen::Vector3f::UnitZ());
  volume.spacing_mm = std::clamp(bounds.sizes().maxCoeff() / options.nodes_along_body, 1.0F, 12.0F);
  const float reach_mm = options.reach_nodes * volume.spacing_mm;
  volume.origin_mm = bounds.min() - Eigen::Vector3f::Constant(reach_mm);
  for (int axis = 0; axis < 3; ++axis) {
    volume.size[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::ceil((bounds.sizes()[axis] + 2.0F * reach_mm) / volume.spacing_mm)) +
        1;
  }
  const auto [nx, ny, nz] = volume.size;
  constexpr int kStep = StartVolume::kRowStep;
  volume.stride = (nx + kStep - 1) / kStep * kStep;
  volume.worth.resize(static_cast<std::size_t>(volume.stride) * static_cast<std::size_t>(ny) *
                      static_cast<std::size_t>(nz));
  const Eigen::Isometry3f ct_from_lying = volume.lying_from_ct.inverse().cast<float>();
  FieldSample sample;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      std::int8_t* worth = volume.row(y, z);
      for (int x = 0; x < nx; ++x) {
        const Eigen::Vector3f at =
            volume.origin_mm + volume.spacing_mm * Eigen::Vector3f(static_cast<float>(x),
                                                                   static_cast<float>(y),
                                                                   static_cast<float>(z));
        if (DistanceField::look_up(fixed.field.coarse(), ct_from_lying * at, sample)) {
          worth[x] = worth_at(sample.distance_mm, reach_mm);
        }
      }
    }
  }
  return volume;
}

}  // namespace mor::internal
