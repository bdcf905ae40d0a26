// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/blended_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

namespace mor::internal {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr std::uint32_t kNoVertex = 0xFFFFFFFFU;

float distance_mm(const Limb& limb, const Vector3f& p) {
  const Vector3f along = limb.end - limb.begin;
  const float share =
      std::clamp((p - limb.begin).dot(along) / std::max(along.squaredNorm(), 1e-6F), 0.0F, 1.0F);
  const float radius_mm = std::lerp(limb.begin_radius_mm, limb.end_radius_mm, share);
  return (p - limb.begin - share * along).norm() - radius_mm;
}

float smooth_minimum(float a, float b, float blend_mm) {
  const float overlap = std::max(blend_mm - std::abs(a - b), 0.0F) / blend_mm;
  return std::min(a, b) - 0.25F * blend_mm * overlap * overlap;
}

/// Distances at the corners of a grid around the limbs.
class DistanceGrid {
 public:
  DistanceGrid(const std::vector<Limb>& limbs, float blend_mm, float cell_mm) : cell_mm_(cell_mm) {
    Eigen::AlignedBox3f bounds;
    for (const auto& limb : limbs) {
      const float radius_mm = std::max(limb.begin_radius_mm, limb.end_radius_mm);
      const Vector3f reach = Vector3f::Constant(radius_mm + blend_mm + 2.0F * cell_mm);
      for (const auto& p : {limb.begin, limb.end}) {
        bounds.extend(p - reach);
        bounds.extend(p + reach);
      }
    }
    origin_ = bounds.min();
    size_ = (bounds.sizes() / cell_mm).array().ceil().cast<int>() + 1;
    values_.reserve(static_cast<std::size_t>(size_.prod()));
    for (int z = 0; z < size_.z(); ++z) {
      for (int y = 0; y < size_.y(); ++y) {
        for (int x = 0; x < size_.x(); ++x) {
          const Vector3f p = place(Vector3f(Vector3i(x, y, z).cast<float>()));
          float value = distance_mm(limbs.front(), p);
          for (std::size_t i = 1; i < limbs.size(); ++i) {
            value = smooth_minimum(value, distance_mm(limbs[i], p), blend_mm);
          }
          values_.push_back(value);
        }
      }
    }
  }

  [[nodiscard]] const Vector3i& size() const { return size_; }
  [[nodiscard]] std::size_t index(const Vector3i& at) const {
    return static_cast<std::size_t>((at.z() * size_.y() + at.y()) * size_.x() + at.x());
  }
  [[nodiscard]] float operator()(const Vector3i& at) const { return values_[index(at)]; }
  [[nodiscard]] Vector3f place(const Vector3f& in_cells) const {
    return origin_ + cell_mm_ * in_cells;
  }

 private:
  float cell_mm_;
  Vector3f origin_;
  Vector3i size_;
  std::vector<float> values_;
};

/// The mean of the places where the surface crosses the cell's edges.
std::optional<Vector3f> crossing(const DistanceGrid& grid, const Vector3i& cell) {
  Vector3f sum = Vector3f::Zero();
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3i step = Vector3i::Unit(axis);
    const Vector3i across = Vector3i::Unit((axis + 1) % 3);
    const Vector3i up = Vector3i::Unit((axis + 2) % 3);
    for (const Vector3i& from :
         {cell, Vector3i(cell + across), Vector3i(cell + up), Vector3i(cell + across + up)}) {
      const float here = grid(from);
      const float there = grid(from + step);
      if ((here < 0.0F) == (there < 0.0F)) continue;
      sum += from.cast<float>() + here / (here - there) * step.cast<float>();
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return Vector3f(sum / static_cast<float>(count));
}

/// Two triangles between the four cells around each grid edge that the surface crosses.
void add_faces(const DistanceGrid& grid,
               const std::vector<std::uint32_t>& vertex_of_cell,
               const Vector3i& at,
               TriangleMesh& mesh) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3i across = Vector3i::Unit((axis + 1) % 3);
    const Vector3i up = Vector3i::Unit((axis + 2) % 3);
    const bool is_inside = grid(at) < 0.0F;
    if (is_inside == (grid(at + Vector3i::Unit(axis)) < 0.0F)) continue;
    std::array<std::uint32_t, 4> corners = {vertex_of_cell[grid.index(at - across - up)],
                                            vertex_of_cell[grid.index(at - up)],
                                            vertex_of_cell[grid.index(at)],
                                            vertex_of_cell[grid.index(at - across)]};
    if (!is_inside) std::swap(corners[1], corners[3]);
    mesh.triangles.push_back({corners[0], corners[1], corners[2]});
    mesh.triangles.push_back({corners[0], corners[2], corners[3]});
  }
}

}  // namespace

TriangleMesh blended_surface(const std::vector<Limb>& limbs, float blend_mm, float cell_mm) {
  const DistanceGrid grid(limbs, blend_mm, cell_mm);
  const Vector3i num_cells = grid.size() - Vector3i::Ones();
  TriangleMesh mesh;
  std::vector<std::uint32_t> vertex_of_cell(static_cast<std::size_t>(grid.size().prod()),
                                            kNoVertex);
  const auto for_cells = [&](int first, const auto& visit) {
    for (int z = first; z < num_cells.z(); ++z) {
      for (int y = first; y < num_cells.y(); ++y) {
        for (int x = first; x < num_cells.x(); ++x) visit(Vector3i(x, y, z));
      }
    }
  };
  for_cells(0, [&](const Vector3i& cell) {
    const auto at = crossing(grid, cell);
    if (!at) return;
    vertex_of_cell[grid.index(cell)] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(grid.place(*at));
  });
  // The margin around the limbs keeps the surface away from the grid's rim.
  for_cells(1, [&](const Vector3i& at) { add_faces(grid, vertex_of_cell, at, mesh); });
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

}  // namespace mor::internal
