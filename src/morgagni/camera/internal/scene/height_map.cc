// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/height_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mor::internal {
namespace {

using Eigen::Vector3f;

int num_cells(float size_mm, float margin_mm) {
  return static_cast<int>((size_mm + 2.0F * margin_mm) / HeightMap::kCellMm) + 2;
}

}  // namespace

HeightMap::HeightMap(const Eigen::AlignedBox3f& bounds, float margin_mm, float table_top_mm)
    : table_top_mm_(table_top_mm),
      left_mm_(bounds.min().x() - margin_mm),
      foot_mm_(bounds.min().z() - margin_mm),
      height_mm_(num_cells(bounds.sizes().x(), margin_mm),
                 num_cells(bounds.sizes().z(), margin_mm),
                 0.0F) {}

void HeightMap::add(const TriangleMesh& mesh) {
  for (const auto& [a, b, c] : mesh.triangles) {
    raise(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
  }
}

/// Cells whose centre lies in the triangle, or within half a cell of a corner.
void HeightMap::raise(const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  const auto in_cells = [&](const Vector3f& p) {
    return Vector3f(
        (p.x() - left_mm_) / kCellMm, table_top_mm_ - p.y(), (p.z() - foot_mm_) / kCellMm);
  };
  const std::array corners = {in_cells(a), in_cells(b), in_cells(c)};
  const auto raise_cell = [&](int x, int z, float height) {
    if (height_mm_.view().contains(x, z)) height_mm_(x, z) = std::max(height_mm_(x, z), height);
  };
  for (const auto& p : corners) {
    raise_cell(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.z())), p.y());
  }
  const Vector3f to_b = corners[1] - corners[0];
  const Vector3f to_c = corners[2] - corners[0];
  const float area = to_b.x() * to_c.z() - to_b.z() * to_c.x();
  if (std::abs(area) < 1e-6F) return;
  const auto [left, right] = std::minmax({corners[0].x(), corners[1].x(), corners[2].x()});
  const auto [low, high] = std::minmax({corners[0].z(), corners[1].z(), corners[2].z()});
  for (int z = static_cast<int>(std::ceil(low)); static_cast<float>(z) <= high; ++z) {
    for (int x = static_cast<int>(std::ceil(left)); static_cast<float>(x) <= right; ++x) {
      const float px = static_cast<float>(x) - corners[0].x();
      const float pz = static_cast<float>(z) - corners[0].z();
      const float u = (px * to_c.z() - pz * to_c.x()) / area;
      const float v = (to_b.x() * pz - to_b.z() * px) / area;
      if (u < 0.0F || v < 0.0F || u + v > 1.0F) continue;
      raise_cell(x, z, corners[0].y() + u * to_b.y() + v * to_c.y());
    }
  }
}

float HeightMap::height_mm(float x_mm, float z_mm) const {
  const float x = (x_mm - left_mm_) / kCellMm;
  const float z = (z_mm - foot_mm_) / kCellMm;
  if (!(x >= 0.0F && z >= 0.0F)) return 0.0F;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(z);
  if (!height_mm_.view().contains(column + 1, row + 1)) return 0.0F;
  const float tx = x - static_cast<float>(column);
  const float tz = z - static_cast<float>(row);
  return std::lerp(std::lerp(height_mm_(column, row), height_mm_(column + 1, row), tx),
                   std::lerp(height_mm_(column, row + 1), height_mm_(column + 1, row + 1), tx),
                   tz);
}

Vector3f HeightMap::top(float x_mm, float z_mm) const {
  return {x_mm, table_top_mm_ - height_mm(x_mm, z_mm), z_mm};
}

Vector3f HeightMap::normal(float x_mm, float z_mm) const {
  constexpr float kReachMm = 12.0F;
  const float along_x =
      (height_mm(x_mm + kReachMm, z_mm) - height_mm(x_mm - kReachMm, z_mm)) / (2.0F * kReachMm);
  const float along_z =
      (height_mm(x_mm, z_mm + kReachMm) - height_mm(x_mm, z_mm - kReachMm)) / (2.0F * kReachMm);
  return Vector3f(-along_x, -1.0F, -along_z).normalized();
}

}  // namespace mor::internal
