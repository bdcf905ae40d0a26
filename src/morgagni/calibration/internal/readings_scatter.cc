// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/readings_scatter.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

/// Of the residuals with those (dx, dy) blocks further and `later` views on.
double correlation(
    const std::vector<Image<float>>& pictures, float limit, int dx, int dy, std::size_t later) {
  const auto is_there = [&](float value) { return std::abs(value) < limit; };
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i + later < pictures.size(); ++i) {
    const auto& a = pictures[i];
    const auto& b = pictures[i + later];
    for (int y = std::max(0, -dy); y < a.height() - std::max(0, dy); ++y) {
      for (int x = std::max(0, -dx); x < a.width() - std::max(0, dx); ++x) {
        const float first = a(x, y);
        const float second = b(x + dx, y + dy);
        if (!is_there(first) || !is_there(second)) continue;
        products += static_cast<double>(first * second);
        squares += 0.5 * static_cast<double>(first * first + second * second);
      }
    }
  }
  return squares > 0.0 ? std::max(0.0, products / squares) : 0.0;
}

}  // namespace

double correlated_readings(const std::vector<Image<float>>& pictures, float limit) {
  constexpr int kReach = 3;
  double in_picture = 1.0;
  for (int dy = 0; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      if (dy == 0 && dx <= 0) continue;
      in_picture += 2.0 * correlation(pictures, limit, dx, dy, 0);
    }
  }
  const auto half = std::max<std::size_t>(1, pictures.size() / 2);
  const double in_time = correlation(pictures, limit, 0, 0, half);
  return in_picture * (1.0 + in_time * static_cast<double>(pictures.size() - 1));
}

}  // namespace mor::internal
