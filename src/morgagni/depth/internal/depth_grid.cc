// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/depth/internal/depth_grid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

namespace mor::internal {
namespace {

constexpr std::uint32_t kNoRun = std::numeric_limits<std::uint32_t>::max();
/// A reading this far before or behind an expected place is something else.
constexpr float kExpectedMm = 80.0F;
/// A piece with fewer of the expected places than this share of the most is left out.
constexpr double kShareOfMost = 0.05;

/// Sets `bit` in `edges[i]` where points `i` and `i + step` are near each other, for `count` pixels
/// from `first` on. A comparison with NaN is false, so pixels without reading have no edges.
void connect_row(const DepthGrid& grid,
                 std::size_t first,
                 std::size_t count,
                 std::ptrdiff_t step,
                 float max_sq_mm2,
                 std::uint8_t bit,
                 std::uint8_t* __restrict edges) {
  const float* __restrict x = grid.x.data() + first;
  const float* __restrict y = grid.y.data() + first;
  const float* __restrict z = grid.z.data() + first;
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = x[i] - x[static_cast<std::ptrdiff_t>(i) + step];
    const float dy = y[i] - y[static_cast<std::ptrdiff_t>(i) + step];
    const float dz = z[i] - z[static_cast<std::ptrdiff_t>(i) + step];
    const bool near = dx * dx + dy * dy + dz * dz <= max_sq_mm2;
    edges[first + i] = static_cast<std::uint8_t>(edges[first + i] | (near ? bit : 0));
  }
}

/// The pixel with a reading that is nearest to (seed_x, seed_y), in pixels.
std::optional<std::size_t> nearest_reading(const DepthGrid& grid, int seed_x, int seed_y) {
  std::optional<std::size_t> best;
  int best_sq = std::numeric_limits<int>::max();
  for (int y = 0; y < grid.height; ++y) {
    const int dy = y - seed_y;
    if (dy * dy >= best_sq) continue;
    for (int x = 0; x < grid.width; ++x) {
      const int sq = (x - seed_x) * (x - seed_x) + dy * dy;
      const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) +
                            static_cast<std::size_t>(x);
      if (sq < best_sq && !std::isnan(grid.z[i])) {
        best_sq = sq;
        best = i;
      }
    }
  }
  return best;
}

}  // namespace

void connect_neighbors(const DepthGrid& grid, float max_edge_mm, std::vector<std::uint8_t>& edges) {
  edges.assign(grid.size(), 0);
  const auto width = static_cast<std::size_t>(grid.width);
  const auto step = static_cast<std::ptrdiff_t>(grid.width);
  const float max_sq_mm2 = max_edge_mm * max_edge_mm;
  for (int y = 0; y < grid.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * width;
    connect_row(grid, row, width - 1, 1, max_sq_mm2, kRight, edges.data());
    if (y + 1 == grid.height) break;
    connect_row(grid, row, width, step, max_sq_mm2, kDown, edges.data());
    connect_row(grid, row, width - 1, step + 1, max_sq_mm2, kDownRight, edges.data());
    connect_row(grid, row + 1, width - 1, step - 1, max_sq_mm2, kDownLeft, edges.data());
  }
}

std::uint32_t RegionGrower::find_root(std::uint32_t run) {
  while (parent_[run] != run) {
    parent_[run] = parent_[parent_[run]];
    run = parent_[run];
  }
  return run;
}

void RegionGrower::unite(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t root_a = find_root(a);
  const std::uint32_t root_b = find_root(b);
  if (root_a < root_b) {
    parent_[root_b] = root_a;
  } else {
    parent_[root_a] = root_b;
  }
}

void RegionGrower::label_runs(const DepthGrid& grid, const std::vector<std::uint8_t>& edges) {
  run_of_pixel_.resize(grid.size());
  std::uint32_t run = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    run_of_pixel_[i] = run;
    // The last pixel of a row has no edge to the right, so runs end with their row.
    run += (edges[i] & kRight) == 0 ? 1 : 0;
  }
  parent_.resize(run);
  std::iota(parent_.begin(), parent_.end(), 0U);
}

void RegionGrower::join_rows(const DepthGrid& grid, const std::vector<std::uint8_t>& edges) {
  const auto width = static_cast<std::size_t>(grid.width);
  std::uint32_t last_above = kNoRun;
  std::uint32_t last_below = kNoRun;
  const auto join = [&](std::size_t above, std::size_t below) {
    const std::uint32_t a = run_of_pixel_[above];
    const std::uint32_t b = run_of_pixel_[below];
    if (a == last_above && b == last_below) return;
    last_above = a;
    last_below = b;
    unite(a, b);
  };
  for (std::size_t i = 0; i + width < grid.size(); ++i) {
    const std::uint8_t bits = edges[i];
    if ((bits & (kDown | kDownRight | kDownLeft)) == 0) continue;
    // Inside a body nearly every pixel joins the two runs that the pixel before has joined.
    if (run_of_pixel_[i] == last_above && run_of_pixel_[i + width - 1] == last_below &&
        run_of_pixel_[i + width] == last_below &&
        (i + width + 1 == grid.size() || run_of_pixel_[i + width + 1] == last_below)) {
      continue;
    }
    if ((bits & kDown) != 0) join(i, i + width);
    if ((bits & kDownRight) != 0) join(i, i + width + 1);
    if ((bits & kDownLeft) != 0) join(i, i + width - 1);
  }
}

void RegionGrower::label_pieces(const DepthGrid& grid, const std::vector<std::uint8_t>& edges) {
  label_runs(grid, edges);
  join_rows(grid, edges);
  // After this every run points at its root: one look-up a pixel below.
  for (std::uint32_t run = 0; run < parent_.size(); ++run) parent_[run] = find_root(run);
}

std::size_t RegionGrower::mark(const std::vector<std::uint8_t>& wanted,
                               std::vector<std::uint8_t>& mask) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    mask[i] = wanted[parent_[run_of_pixel_[i]]];
    count += mask[i];
  }
  return count;
}

std::size_t RegionGrower::grow(const DepthGrid& grid,
                               const std::vector<std::uint8_t>& edges,
                               int seed_x,
                               int seed_y,
                               std::vector<std::uint8_t>& mask) {
  mask.assign(grid.size(), 0);
  const auto seed = nearest_reading(grid, seed_x, seed_y);
  if (!seed) return 0;
  label_pieces(grid, edges);
  std::vector<std::uint8_t> wanted(parent_.size(), 0);
  wanted[parent_[run_of_pixel_[*seed]]] = 1;
  return mark(wanted, mask);
}

std::size_t RegionGrower::grow(const DepthGrid& grid,
                               const std::vector<std::uint8_t>& edges,
                               std::span<const Expected> expected,
                               std::vector<std::uint8_t>& mask) {
  mask.assign(grid.size(), 0);
  label_pieces(grid, edges);
  std::map<std::uint32_t, int> votes;
  for (const Expected& place : expected) {
    const std::size_t i = static_cast<std::size_t>(place.y) * static_cast<std::size_t>(grid.width) +
                          static_cast<std::size_t>(place.x);
    // Written so that a pixel without reading, NaN, has no vote.
    if (std::abs(grid.z[i] - place.z_mm) < kExpectedMm) ++votes[parent_[run_of_pixel_[i]]];
  }
  int most = 0;
  for (const auto& [piece, count] : votes) most = std::max(most, count);
  std::vector<std::uint8_t> wanted(parent_.size(), 0);
  for (const auto& [piece, count] : votes) {
    wanted[piece] = count >= kShareOfMost * most ? 1 : 0;
  }
  return mark(wanted, mask);
}

}  // namespace mor::internal
