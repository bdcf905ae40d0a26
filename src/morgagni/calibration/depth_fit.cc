// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/depth_fit.h"

#include <algorithm>
#include <map>
#include <set>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/statistics.h"

namespace mor {
namespace {

constexpr double kSameDistance = 0.06;
constexpr int kTilesX = 8;
constexpr int kTilesY = 6;

tl::unexpected<Error> refuse(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

double median_distance(const std::vector<DepthReading>& readings, int view) {
  std::vector<double> distances;
  for (const auto& reading : readings) {
    if (reading.view == view) distances.push_back(reading.true_mm);
  }
  return quantile(std::move(distances), 0.5);
}

int count_distances(const std::vector<DepthReading>& readings, const std::set<int>& views) {
  std::vector<double> distances;
  for (const int view : views) distances.push_back(median_distance(readings, view));
  std::ranges::sort(distances);
  int count = 0;
  double last_mm = 0.0;
  for (const double distance_mm : distances) {
    if (distance_mm < last_mm * (1.0 + kSameDistance)) continue;
    last_mm = distance_mm;
    ++count;
  }
  return count;
}

/// Share of the picture's tiles that were read at two distances or more.
double covered_share(const std::vector<DepthReading>& readings, int width_px, int height_px) {
  struct Range {
    double least = 1e9;
    double most = 0.0;
  };
  std::map<int, Range> tiles;
  for (const auto& reading : readings) {
    const int x = std::min(kTilesX - 1, static_cast<int>(reading.px.x() * kTilesX / width_px));
    const int y = std::min(kTilesY - 1, static_cast<int>(reading.px.y() * kTilesY / height_px));
    auto& range = tiles[y * kTilesX + x];
    range.least = std::min(range.least, reading.true_mm);
    range.most = std::max(range.most, reading.true_mm);
  }
  const auto good = std::ranges::count_if(tiles, [](const auto& tile) {
    return tile.second.most > tile.second.least * (1.0 + kSameDistance);
  });
  return static_cast<double>(good) / (kTilesX * kTilesY);
}

}  // namespace

std::string_view to_string(DepthForm form) {
  switch (form) {
    case DepthForm::kAuto:
      return "auto";
    case DepthForm::kDisparity:
      return "disparity";
    case DepthForm::kTimeOfFlight:
      return "time-of-flight";
  }
  return "";
}

Result<DepthSpan> depth_span(const std::vector<DepthReading>& readings,
                             int width_px,
                             int height_px,
                             const DepthFitOptions& options) {
  DepthSpan span;
  std::set<int> views;
  std::vector<double> distances;
  for (const auto& reading : readings) {
    views.insert(reading.view);
    distances.push_back(reading.seen_mm);
  }
  span.num_distances = count_distances(readings, views);
  const double near_mm = quantile(distances, 0.01);
  const double far_mm = quantile(distances, 0.99);
  if (span.num_distances < options.min_distances || far_mm < options.min_far_to_near * near_mm) {
    return refuse(fmt::format(
        "the depth was seen at {} distances from {:.0f} to {:.0f} mm: at least {} are needed, the "
        "farthest {:.2f} times the nearest",
        span.num_distances,
        near_mm,
        far_mm,
        options.min_distances,
        options.min_far_to_near));
  }
  span.coverage = covered_share(readings, width_px, height_px);
  if (span.coverage < options.min_coverage) {
    return refuse(fmt::format(
        "the board covered {:.0f} % of the depth picture at two distances, at least {:.0f} % are "
        "needed: hang it on a flat wall, or hold it in more places, near and far",
        100.0 * span.coverage,
        100.0 * options.min_coverage));
  }
  return span;
}

}  // namespace mor
