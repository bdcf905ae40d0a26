// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace mor::internal {

/// The corners of a marching cube: corner c lies at (c & 1, c >> 1 & 1, c >> 2 & 1).
/// Its twelve edges, each from its lower to its upper corner: 0-3 along x, 4-7 along y, 8-11 along
/// z.
struct CubeEdge {
  int low = 0;
  int high = 0;
};
inline constexpr std::array<CubeEdge, 12> kCubeEdges = {{{0, 1},
                                                         {2, 3},
                                                         {4, 5},
                                                         {6, 7},  // x
                                                         {0, 2},
                                                         {1, 3},
                                                         {4, 6},
                                                         {5, 7},  // y
                                                         {0, 4},
                                                         {1, 5},
                                                         {2, 6},
                                                         {3, 7}}};  // z

/// For each of the 256 ways in which the corners lie inside (bit set) or outside: the triangles
/// between them as triples of edges, counter-clockwise seen from outside.
///
/// The table is made by walking the cube's faces. On a face with two inside corners across from
/// each other, each is cut off by itself; as that depends on the face alone, both cubes at a face
/// agree and the surface has no cracks. No diagonal inside a polygon lies in a face, so that no
/// edge is used by more than two triangles.
using CubeCases = std::array<std::vector<std::array<std::uint8_t, 3>>, 256>;
[[nodiscard]] const CubeCases& cube_cases();

}  // namespace mor::internal
