// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "morgagni/geometry/triangle_mesh.h"

/// Surfaces made in code, for tests and benchmarks.
namespace mor::testing {

/// A grid that closes on itself both ways: `point(u, v)` with u, v in [0, 2 pi).
template <class Point>
TriangleMesh closed_grid(int num_u, int num_v, const Point& point) {
  TriangleMesh mesh;
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>((i % num_u) * num_v + j % num_v);
  };
  for (int i = 0; i < num_u; ++i) {
    for (int j = 0; j < num_v; ++j) {
      const double u = 2.0 * std::numbers::pi * i / num_u;
      const double v = 2.0 * std::numbers::pi * j / num_v;
      mesh.vertices.push_back(point(u, v).template cast<float>());
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

/// A bent tube, as ribs and arches are: 2 * num_u * num_v triangles.
inline TriangleMesh make_torus(
    const Eigen::Vector3d& center, double ring_mm, double tube_mm, int num_u, int num_v) {
  return closed_grid(num_u, num_v, [&](double u, double v) -> Eigen::Vector3d {
    const double r = ring_mm + tube_mm * std::cos(v);
    return center + Eigen::Vector3d(r * std::cos(u), r * std::sin(u), tube_mm * std::sin(v));
  });
}

/// Rings of latitude between two poles.
inline TriangleMesh make_sphere(const Eigen::Vector3d& center, double radius_mm, int num_rings) {
  TriangleMesh mesh;
  const int num_columns = 2 * num_rings;
  const auto add = [&](const Eigen::Vector3d& direction) {
    mesh.vertices.push_back((center + radius_mm * direction).cast<float>());
    mesh.normals.push_back(direction.cast<float>());
  };
  const auto at = [&](int ring, int column) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * num_columns + column % num_columns);
  };
  add(Eigen::Vector3d::UnitZ());
  for (int ring = 1; ring < num_rings; ++ring) {
    for (int column = 0; column < num_columns; ++column) {
      const double polar = std::numbers::pi * ring / num_rings;
      const double around = 2.0 * std::numbers::pi * column / num_columns;
      add({std::sin(polar) * std::cos(around),
           std::sin(polar) * std::sin(around),
           std::cos(polar)});
    }
  }
  add(-Eigen::Vector3d::UnitZ());
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (int column = 0; column < num_columns; ++column) {
    mesh.triangles.push_back({0, at(1, column), at(1, column + 1)});
    for (int ring = 1; ring + 1 < num_rings; ++ring) {
      mesh.triangles.push_back({at(ring, column), at(ring + 1, column), at(ring + 1, column + 1)});
      mesh.triangles.push_back({at(ring, column), at(ring + 1, column + 1), at(ring, column + 1)});
    }
    mesh.triangles.push_back({at(num_rings - 1, column), last, at(num_rings - 1, column + 1)});
  }
  return mesh;
}

/// Around the origin, each face in `cells` x `cells` squares: lens distortion bends long edges.
inline TriangleMesh make_cube(double half_mm, int cells) {
  TriangleMesh mesh;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 == 0 ? 1.0 : -1.0;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        Eigen::Vector3d at;
        at[axis] = side;
        at[(axis + 1) % 3] = side * (2.0 * i / cells - 1.0);
        at[(axis + 2) % 3] = 2.0 * j / cells - 1.0;
        mesh.vertices.push_back((half_mm * at).cast<float>());
        mesh.normals.push_back(side * Eigen::Vector3f::Unit(axis));
        if (i == cells || j == cells) continue;
        const auto a = first + static_cast<std::uint32_t>(i * (cells + 1) + j);
        const auto b = a + static_cast<std::uint32_t>(cells + 1);
        mesh.triangles.push_back({a, b, b + 1});
        mesh.triangles.push_back({a, b + 1, a + 1});
      }
    }
  }
  return mesh;
}

inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({a + offset, b + offset, c + offset});
  }
}

/// Ribs around a ball: what a renderer meets in a chest, 250 mm wide around the origin.
inline TriangleMesh make_bones(std::size_t num_triangles) {
  constexpr int kNumRibs = 10;
  TriangleMesh mesh = make_sphere(Eigen::Vector3d::Zero(), 45.0, 20);
  const double per_rib = static_cast<double>(num_triangles - mesh.triangles.size()) / kNumRibs;
  const int num_around = std::max(3, static_cast<int>(std::sqrt(per_rib / 20.0)));
  const int num_along = static_cast<int>(per_rib / (2.0 * num_around));
  for (int i = 0; i < kNumRibs; ++i) {
    const Eigen::Vector3d center(0.0, 0.0, 24.0 * (i - 0.5 * (kNumRibs - 1)));
    append(mesh, make_torus(center, 115.0, 7.0, num_along, num_around));
  }
  return mesh;
}

}  // namespace mor::testing
