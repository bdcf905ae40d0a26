// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace mor::internal {

/// A down-sampled depth image as points on a grid, row by row, one array a coordinate so that the
/// compiler can use vector instructions. A pixel without reading has NaN in all three.
struct DepthGrid {
  int width = 0;
  int height = 0;
  std::vector<float> x, y, z;  ///< mm, frame depth.

  [[nodiscard]] std::size_t size() const { return z.size(); }
};

/// Bits of `GridEdges`: the neighbours that a pixel is connected to. The other four directions are
/// the neighbours' own.
enum GridEdge : std::uint8_t {
  kRight = 1,
  kDown = 2,
  kDownRight = 4,
  kDownLeft = 8,
};

/// Which neighbours are at most `max_edge_mm` apart in space.
void connect_neighbors(const DepthGrid& grid, float max_edge_mm, std::vector<std::uint8_t>& edges);

/// Parts the picture into pieces of connected pixels and marks those that are wanted.
class RegionGrower {
 public:
  /// A pixel of the grid where the body's surface is expected, and how far away.
  struct Expected {
    int x = 0;
    int y = 0;
    float z_mm = 0.0F;
  };

  /// Sets `mask` to 1 where a chain of edges leads from the pixel nearest to (seed_x, seed_y) that
  /// has a reading, 0 elsewhere. @return The number of pixels in it; 0 when no pixel has a reading.
  std::size_t grow(const DepthGrid& grid,
                   const std::vector<std::uint8_t>& edges,
                   int seed_x,
                   int seed_y,
                   std::vector<std::uint8_t>& mask);

  /// The same from the pieces that expected places lie on: of the one with the most, and of any
  /// with a fair share of that. @return 0 when none lies on any.
  std::size_t grow(const DepthGrid& grid,
                   const std::vector<std::uint8_t>& edges,
                   std::span<const Expected> expected,
                   std::vector<std::uint8_t>& mask);

 private:
  std::uint32_t find_root(std::uint32_t run);
  void unite(std::uint32_t a, std::uint32_t b);
  /// Every run points at the first one of its piece.
  void label_pieces(const DepthGrid& grid, const std::vector<std::uint8_t>& edges);
  void label_runs(const DepthGrid& grid, const std::vector<std::uint8_t>& edges);
  void join_rows(const DepthGrid& grid, const std::vector<std::uint8_t>& edges);
  std::size_t mark(const std::vector<std::uint8_t>& wanted, std::vector<std::uint8_t>& mask) const;

  std::vector<std::uint32_t> run_of_pixel_;
  std::vector<std::uint32_t> parent_;
};

}  // namespace mor::internal
