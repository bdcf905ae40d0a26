// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "morgagni/render/overlay_view.h"

namespace mor::internal {

/// A transfer function as a look-up of HU, one entry a HU.
struct TransferTable {
  static constexpr int kLeastHu = -1024;  ///< Less is air, and more than the most is metal.
  static constexpr int kMostHu = 3071;
  static constexpr int kNumEntries = kMostHu - kLeastHu + 1;

  std::vector<float> opacity;      ///< On one step of the ray, 0..1.
  std::vector<float> opacity_sum;  ///< From the first entry to each: the mean opacity between two
                                   ///< samples is a difference, however steep the function is.
  std::vector<float> moment_sum;   ///< Of opacity times entry: where between two samples it lies.
  float surface_entry = kNumEntries;  ///< The first that is so dense that it is seen as a surface.
  std::vector<std::uint32_t> colors;  ///< 0x00bbggrr, not premultiplied.
  std::vector<std::int32_t> num_seen_below;  ///< Entries below this one that are not transparent.

  /// Whether a voxel from `least` to `most` HU, or between, can be seen.
  [[nodiscard]] bool is_seen(int least_hu, int most_hu) const;
};

[[nodiscard]] TransferTable make_transfer_table(const VolumeView& view, float step_mm);

}  // namespace mor::internal
