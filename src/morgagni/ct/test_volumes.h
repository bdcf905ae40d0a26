// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor {

inline constexpr std::int16_t kAirHu = -1000;
inline constexpr std::int16_t kTissueHu = 40;

/// A volume about the origin whose HU go from tissue to air over one voxel where `depth_mm`
/// (positive inside) crosses zero: its surface at -300 HU and above is known.
inline Volume make_volume(int side,
                          double spacing_mm,
                          const std::function<double(const Eigen::Vector3d&)>& depth_mm) {
  Volume volume;
  volume.size = {side, side, side};
  volume.spacing_mm = Eigen::Vector3d::Constant(spacing_mm);
  volume.ct_from_grid.translation() = Eigen::Vector3d::Constant(-0.5 * (side - 1) * spacing_mm);
  volume.hu.reserve(static_cast<std::size_t>(side) * side * side);
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const Eigen::Vector3d place = volume.ct_from_grid * (Eigen::Vector3d(x, y, z) * spacing_mm);
        const double share = std::clamp(depth_mm(place) / spacing_mm + 0.5, 0.0, 1.0);
        volume.hu.push_back(
            static_cast<std::int16_t>(std::lround(kAirHu + share * (kTissueHu - kAirHu))));
      }
    }
  }
  return volume;
}

/// Of a closed mesh, positive when its triangles are counter-clockwise seen from outside.
inline double enclosed_volume_mm3(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += mesh.vertices[a].cast<double>().dot(
        mesh.vertices[b].cast<double>().cross(mesh.vertices[c].cast<double>()));
  }
  return sum / 6.0;
}

}  // namespace mor
