// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// A surface with its looks.
struct PaintedMesh {
  TriangleMesh mesh;                    ///< With normals.
  std::vector<Eigen::Vector3f> albedo;  ///< One a vertex, 0..255.
  std::vector<float> gloss;             ///< One a vertex, 0..255: the highlight's brightness.

  /// Adds a copy of `other`, moved.
  void append(const PaintedMesh& other,
              const Eigen::Isometry3f& this_from_other = Eigen::Isometry3f::Identity());
};

/// A mesh in one colour; computes the normals where it has none.
[[nodiscard]] PaintedMesh painted(TriangleMesh mesh, const Eigen::Vector3f& albedo, float gloss);

/// Skin is not one colour: it is redder in wide soft patches, paler in others, with a few moles.
[[nodiscard]] PaintedMesh painted_as_skin(TriangleMesh mesh, std::uint64_t seed);

}  // namespace mor::internal
