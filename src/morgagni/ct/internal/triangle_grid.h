// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// Finds the nearest point of a mesh by a grid of cells that know their triangles. Keeps a
/// reference: the mesh must outlive it.
class TriangleGrid {
 public:
  explicit TriangleGrid(const TriangleMesh& mesh);

  /// To the nearest point of any triangle. @threads Safe to call from many at once.
  [[nodiscard]] double distance_mm(const Eigen::Vector3f& point) const;

 private:
  [[nodiscard]] std::array<int, 3> cell_of(const Eigen::Vector3f& point) const;
  [[nodiscard]] std::size_t cell_index(int x, int y, int z) const;
  /// Squared distance to the triangles of the shell of cells `ring` around `center`.
  [[nodiscard]] float shell_distance_sq(const Eigen::Vector3f& point,
                                        const std::array<int, 3>& center,
                                        int ring) const;

  const TriangleMesh& mesh_;
  Eigen::Vector3f origin_;
  float cell_mm_ = 1.0F;
  std::array<int, 3> size_{};
  std::vector<std::uint32_t> starts_, triangles_;
};

}  // namespace mor::internal
