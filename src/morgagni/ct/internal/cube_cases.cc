// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/cube_cases.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace mor::internal {
namespace {

using Polygon = std::vector<int>;  // Of edges.

constexpr int kNone = -1;
/// The corners of each face, counter-clockwise seen from outside the cube.
constexpr std::array<std::array<int, 4>, 6> kFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

int edge_between(int a, int b) {
  for (int edge = 0; edge < 12; ++edge) {
    const auto [low, high] = kCubeEdges[static_cast<std::size_t>(edge)];
    if (low == std::min(a, b) && high == std::max(a, b)) return edge;
  }
  return kNone;
}

bool share_face(int edge_a, int edge_b) {
  const auto on_face = [](int edge, const std::array<int, 4>& face) {
    const auto [low, high] = kCubeEdges[static_cast<std::size_t>(edge)];
    return std::count(face.begin(), face.end(), low) + std::count(face.begin(), face.end(), high) ==
           2;
  };
  return std::any_of(kFaces.begin(), kFaces.end(), [&](const auto& face) {
    return on_face(edge_a, face) && on_face(edge_b, face);
  });
}

/// Which edge the outline goes to from each edge: on every face, a stretch of inside corners is
/// left and entered once; the outline runs from where it is left to where it is entered.
std::array<int, 12> outline_steps(unsigned inside) {
  const auto is_in = [&](int corner) { return (inside >> corner & 1U) != 0; };
  std::array<int, 12> next{};
  next.fill(kNone);
  for (const auto& face : kFaces) {
    for (std::size_t i = 0; i < 4; ++i) {
      const int corner = face[i];
      const int before = face[(i + 3) % 4];
      if (!is_in(corner) || is_in(before)) continue;
      std::size_t last = i;
      while (is_in(face[(last + 1) % 4])) ++last;
      const int entered = edge_between(before, corner);
      const int left = edge_between(face[last % 4], face[(last + 1) % 4]);
      next[static_cast<std::size_t>(entered)] = left;
    }
  }
  return next;
}

/// Cuts polygon[first..last] into triangles with the fewest diagonals in faces of the cube.
/// @return Their number.
int triangulate(const Polygon& polygon,
                std::size_t first,
                std::size_t last,
                std::vector<std::array<std::uint8_t, 3>>& triangles) {
  if (last < first + 2) return 0;
  int fewest = std::numeric_limits<int>::max();
  std::vector<std::array<std::uint8_t, 3>> best;
  for (std::size_t middle = first + 1; middle < last; ++middle) {
    std::vector<std::array<std::uint8_t, 3>> tried;
    int num_bad = triangulate(polygon, first, middle, tried);
    num_bad += triangulate(polygon, middle, last, tried);
    if (middle > first + 1 && share_face(polygon[first], polygon[middle])) ++num_bad;
    if (last > middle + 1 && share_face(polygon[middle], polygon[last])) ++num_bad;
    tried.push_back({static_cast<std::uint8_t>(polygon[first]),
                     static_cast<std::uint8_t>(polygon[middle]),
                     static_cast<std::uint8_t>(polygon[last])});
    if (num_bad < fewest) {
      fewest = num_bad;
      best = std::move(tried);
    }
  }
  triangles.insert(triangles.end(), best.begin(), best.end());
  return fewest;
}

CubeCases make_cases() {
  CubeCases cases;
  for (unsigned inside = 0; inside < 256; ++inside) {
    auto next = outline_steps(inside);
    for (int start = 0; start < 12; ++start) {
      Polygon polygon;
      for (int edge = start; next[static_cast<std::size_t>(edge)] != kNone;) {
        polygon.push_back(edge);
        edge = std::exchange(next[static_cast<std::size_t>(edge)], kNone);
      }
      if (!polygon.empty()) triangulate(polygon, 0, polygon.size() - 1, cases[inside]);
    }
  }
  return cases;
}

}  // namespace

const CubeCases& cube_cases() {
  static const CubeCases cases = make_cases();
  return cases;
}

}  // namespace mor::internal
