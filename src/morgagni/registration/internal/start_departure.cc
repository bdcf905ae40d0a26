// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_departure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace mor::internal {
namespace {

constexpr float kOnSkin = 0.6F;  ///< Misfits up to this are on the skin, above it or below.
constexpr float kBefore = -1.0F;
constexpr float kFarBefore = -4.0F;  ///< From there on it is another thing's business.
constexpr float kEdge = 0.3F;        ///< Neighbours that differ more are parted by an edge.
constexpr std::size_t kLeastNeighbours = 5;

/// The median of the 3x3 pixels around each: the noise of single readings is no edge.
Image<float> smoothed(const Image<float>& misfit) {
  Image<float> smooth(misfit.width(), misfit.height(), std::numeric_limits<float>::quiet_NaN());
  std::array<float, 9> around{};
  for (int y = 1; y + 1 < misfit.height(); ++y) {
    for (int x = 1; x + 1 < misfit.width(); ++x) {
      if (std::isnan(misfit(x, y))) continue;
      std::size_t count = 0;
      for (int v = y - 1; v <= y + 1; ++v) {
        for (int u = x - 1; u <= x + 1; ++u) {
          if (!std::isnan(misfit(u, v))) around[count++] = misfit(u, v);
        }
      }
      if (count < kLeastNeighbours) continue;
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
      std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count));
      smooth(x, y) = *middle;
    }
  }
  return smooth;
}

}  // namespace

int count_departing(const Image<float>& misfit) {
  const Image<float> smooth = smoothed(misfit);
  Image<std::uint8_t> is_reached(misfit.width(), misfit.height(), std::uint8_t{0});
  std::vector<std::pair<int, int>> front;
  for (int y = 0; y < smooth.height(); ++y) {
    for (int x = 0; x < smooth.width(); ++x) {
      if (!(std::abs(smooth(x, y)) < kOnSkin)) continue;
      is_reached(x, y) = 1;
      front.emplace_back(x, y);
    }
  }
  int num_departing = 0;
  while (!front.empty()) {
    const auto [x, y] = front.back();
    front.pop_back();
    for (const auto& [u, v] : {std::pair{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}}) {
      if (!smooth.view().contains(u, v) || is_reached(u, v) != 0) continue;
      const float there = smooth(u, v);
      // Written so that NaN is not reached.
      if (!(there > kFarBefore && there < kOnSkin)) continue;
      if (std::abs(there - smooth(x, y)) > kEdge) continue;
      is_reached(u, v) = 1;
      front.emplace_back(u, v);
      if (there < kBefore) ++num_departing;
    }
  }
  return num_departing;
}

}  // namespace mor::internal
