// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/transfer_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace mor::internal {
namespace {

constexpr float kSurfacePerMm = 0.3F;

TransferPoint at(std::span<const TransferPoint> points, float hu) {
  const auto above = std::find_if(
      points.begin(), points.end(), [hu](const TransferPoint& point) { return point.hu > hu; });
  if (above == points.begin()) return {hu, 0.0F, points.front().color};
  if (above == points.end()) return points.back();
  const TransferPoint& below = *(above - 1);
  const float share = (hu - below.hu) / (above->hu - below.hu);
  TransferPoint result{hu, std::lerp(below.opacity_per_mm, above->opacity_per_mm, share), {}};
  for (std::size_t i = 0; i < 3; ++i) {
    result.color[i] = std::lerp(below.color[i], above->color[i], share);
  }
  return result;
}

std::uint32_t packed(const std::array<float, 3>& color) {
  const auto byte = [](float share) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(share, 0.0F, 1.0F) * 255.0F));
  };
  return byte(color[0]) | (byte(color[1]) << 8U) | (byte(color[2]) << 16U);
}

}  // namespace

bool TransferTable::is_seen(int least_hu, int most_hu) const {
  const auto first = static_cast<std::size_t>(std::clamp(least_hu, kLeastHu, kMostHu) - kLeastHu);
  const auto last = static_cast<std::size_t>(std::clamp(most_hu, kLeastHu, kMostHu) - kLeastHu);
  return num_seen_below[last + 1] > num_seen_below[first];
}

TransferTable make_transfer_table(const VolumeView& view, float step_mm) {
  TransferTable table;
  table.opacity.resize(TransferTable::kNumEntries);
  table.opacity_sum.resize(TransferTable::kNumEntries);
  table.moment_sum.resize(TransferTable::kNumEntries);
  table.colors.resize(TransferTable::kNumEntries);
  table.num_seen_below.resize(TransferTable::kNumEntries + 1);
  const auto points = transfer_points(view.preset);
  const VolumeWindow own = volume_window(view.preset);
  for (int i = 0; i < TransferTable::kNumEntries; ++i) {
    const auto entry = static_cast<std::size_t>(i);
    if (!points.empty()) {
      const float hu = static_cast<float>(i + TransferTable::kLeastHu);
      const float own_hu = own.level_hu + (hu - view.level_hu) * own.window_hu / view.window_hu;
      const TransferPoint point = at(points, own_hu);
      // The first entry is the air beside the body too, which is never seen.
      const float per_mm = i == 0 ? 0.0F : point.opacity_per_mm;
      table.opacity[entry] = 1.0F - std::pow(1.0F - per_mm, step_mm);
      table.colors[entry] = packed(point.color);
      if (per_mm >= kSurfacePerMm) {
        table.surface_entry = std::min(table.surface_entry, static_cast<float>(i));
      }
    }
    if (i > 0) {
      table.opacity_sum[entry] =
          table.opacity_sum[entry - 1] + 0.5F * (table.opacity[entry - 1] + table.opacity[entry]);
      const float middle = static_cast<float>(i) - 0.5F;
      table.moment_sum[entry] = table.moment_sum[entry - 1] +
                                middle * (table.opacity_sum[entry] - table.opacity_sum[entry - 1]);
    }
    table.num_seen_below[entry + 1] =
        table.num_seen_below[entry] + (table.opacity[entry] > 0.0F ? 1 : 0);
  }
  return table;
}

}  // namespace mor::internal
