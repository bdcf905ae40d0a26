// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "morgagni/geometry/volume.h"
#include "morgagni/render/internal/transfer_table.h"

namespace mor::internal {

/// The volume in bricks of 8^3 cells between voxels, so that rays leap over what is transparent.
class VolumeBricks {
 public:
  static constexpr int kCells = 8;  ///< A side.

  explicit VolumeBricks(const Volume& volume);

  /// For each brick how many bricks lie between it and the nearest that can be seen, diagonals
  /// counted as one: 0, it can be seen; d, all bricks nearer than d are transparent.
  [[nodiscard]] std::vector<std::uint8_t> distances_to_seen(const TransferTable& table) const;

  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }

 private:
  struct Range {
    std::int16_t least_hu;
    std::int16_t most_hu;
  };

  std::array<int, 3> size_{};
  std::vector<Range> ranges_;
};

}  // namespace mor::internal
