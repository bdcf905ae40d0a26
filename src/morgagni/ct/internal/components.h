// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "morgagni/ct/internal/bit_mask.h"

namespace mor::internal {

/// The connected parts of a mask (voxels joined by their faces), found run by run: a run is a
/// stretch of set voxels in a row, so that the work goes with the runs, not with the voxels.
class Components {
 public:
  struct Part {
    std::size_t num_voxels = 0;
    bool at_side = false;  ///< Touches a face of the volume across x or y (not z).
    int low_x = 0;
    int high_x = 0;
    int low_y = 0;
    int high_y = 0;
    int low_z = 0;
    int high_z = 0;
  };

  explicit Components(const BitMask& mask);

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// Index of the part with most voxels; the mask must not be empty.
  [[nodiscard]] std::size_t largest() const;
  /// The voxels of the parts for which `wanted(index)` holds.
  [[nodiscard]] BitMask select(const std::function<bool(std::size_t)>& wanted) const;
  /// The part that a voxel belongs to.
  [[nodiscard]] std::optional<std::size_t> part_at(const std::array<int, 3>& voxel) const;
  /// At most `num` voxels of a part, spread over its length in z.
  [[nodiscard]] std::vector<std::array<int, 3>> samples(std::size_t part, std::size_t num) const;
  /// How many voxels of each part are set in `other` too.
  [[nodiscard]] std::vector<std::size_t> overlap(const BitMask& other) const;

 private:
  struct Run {
    std::int32_t y, z, begin, end;
    std::uint32_t part;
  };

  void find_runs(const BitMask& mask);
  void join_rows();
  void number_parts();
  void measure(const Run& run);
  [[nodiscard]] std::uint32_t root(std::uint32_t run);

  std::array<int, 3> size_;
  std::vector<Run> runs_;
  std::vector<std::size_t> row_starts_;  ///< Of each row's runs, one more at the end.
  std::vector<std::uint32_t> parents_;
  std::vector<Part> parts_;
};

}  // namespace mor::internal
