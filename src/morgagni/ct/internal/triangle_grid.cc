// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/triangle_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace mor::internal {
namespace {

float segment_distance_sq(const Eigen::Vector3f& point,
                          const Eigen::Vector3f& start,
                          const Eigen::Vector3f& end) {
  const Eigen::Vector3f along = end - start;
  const float length_sq = along.squaredNorm();
  const float share =
      length_sq > 0.0F ? std::clamp((point - start).dot(along) / length_sq, 0.0F, 1.0F) : 0.0F;
  return (point - start - share * along).squaredNorm();
}

float triangle_distance_sq(const Eigen::Vector3f& point,
                           const Eigen::Vector3f& a,
                           const Eigen::Vector3f& b,
                           const Eigen::Vector3f& c) {
  const Eigen::Vector3f normal = (b - a).cross(c - a);
  const auto left_of = [&](const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
    return normal.dot((to - from).cross(point - from)) >= 0.0F;
  };
  const float normal_sq = normal.squaredNorm();
  if (normal_sq > 0.0F && left_of(a, b) && left_of(b, c) && left_of(c, a)) {
    const float height = normal.dot(point - a);
    return height * height / normal_sq;
  }
  return std::min({segment_distance_sq(point, a, b),
                   segment_distance_sq(point, b, c),
                   segment_distance_sq(point, c, a)});
}

}  // namespace

TriangleGrid::TriangleGrid(const TriangleMesh& mesh) : mesh_(mesh) {
  const auto bounds = mesh.bounds();
  origin_ = bounds.min();
  const double area = surface_area_mm2(mesh);
  // About two triangles to a cell that the surface crosses.
  cell_mm_ = std::max(
      1e-3F,
      static_cast<float>(std::sqrt(2.0 * area / static_cast<double>(mesh.triangles.size()))));
  cell_mm_ = std::max(cell_mm_, bounds.sizes().maxCoeff() / 500.0F);
  for (int axis = 0; axis < 3; ++axis)
    size_[static_cast<std::size_t>(axis)] = static_cast<int>(bounds.sizes()[axis] / cell_mm_) + 1;

  const auto for_cells = [&](const Triangle& triangle, const auto& visit) {
    Eigen::AlignedBox3f box;
    for (const auto corner : triangle) box.extend(mesh.vertices[corner]);
    const auto low = cell_of(box.min());
    const auto high = cell_of(box.max());
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x) visit(cell_index(x, y, z));
  };
  starts_.assign(cell_index(size_[0] - 1, size_[1] - 1, size_[2] - 1) + 2, 0);
  for (const auto& triangle : mesh.triangles)
    for_cells(triangle, [&](std::size_t cell) { ++starts_[cell + 1]; });
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  triangles_.resize(starts_.back());
  auto next = starts_;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    for_cells(mesh.triangles[i], [&](std::size_t cell) { triangles_[next[cell]++] = i; });
}

std::array<int, 3> TriangleGrid::cell_of(const Eigen::Vector3f& point) const {
  std::array<int, 3> cell{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const float place = std::floor((point[axis] - origin_[axis]) / cell_mm_);
    cell[i] = static_cast<int>(std::clamp(place, 0.0F, static_cast<float>(size_[i] - 1)));
  }
  return cell;
}

std::size_t TriangleGrid::cell_index(int x, int y, int z) const {
  return (static_cast<std::size_t>(z) * size_[1] + y) * static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(x);
}

float TriangleGrid::shell_distance_sq(const Eigen::Vector3f& point,
                                      const std::array<int, 3>& center,
                                      int ring) const {
  float nearest_sq = std::numeric_limits<float>::infinity();
  const auto low = [&](std::size_t axis) { return std::max(0, center[axis] - ring); };
  const auto high = [&](std::size_t axis) {
    return std::min(size_[axis] - 1, center[axis] + ring);
  };
  for (int z = low(2); z <= high(2); ++z) {
    for (int y = low(1); y <= high(1); ++y) {
      const bool whole_row = std::abs(z - center[2]) == ring || std::abs(y - center[1]) == ring;
      for (int x = low(0); x <= high(0); ++x) {
        if (!whole_row && std::abs(x - center[0]) != ring) continue;
        const std::size_t cell = cell_index(x, y, z);
        for (std::uint32_t i = starts_[cell]; i < starts_[cell + 1]; ++i) {
          const auto& [a, b, c] = mesh_.triangles[triangles_[i]];
          nearest_sq = std::min(
              nearest_sq,
              triangle_distance_sq(point, mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]));
        }
      }
    }
  }
  return nearest_sq;
}

double TriangleGrid::distance_mm(const Eigen::Vector3f& point) const {
  const auto center = cell_of(point);
  const int last_ring = std::max({size_[0], size_[1], size_[2]});
  float nearest_sq = std::numeric_limits<float>::infinity();
  // A point outside the grid is measured from the cell nearest to it; what lies in a shell farther
  // out is farther away than the shells inside, less the one cell that the point itself may fill.
  for (int ring = 0; ring <= last_ring; ++ring) {
    const float reached_mm = static_cast<float>(ring - 1) * cell_mm_;
    if (ring > 1 && reached_mm * reached_mm > nearest_sq) break;
    nearest_sq = std::min(nearest_sq, shell_distance_sq(point, center, ring));
  }
  return std::sqrt(static_cast<double>(nearest_sq));
}

}  // namespace mor::internal
