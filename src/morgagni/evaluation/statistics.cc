// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mor {

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double position = fraction * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], position - static_cast<double>(below));
}

Summary summarize(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto count = static_cast<double>(values.size());
  Summary summary;
  summary.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double sum_sq = 0.0;
  for (const double value : values) sum_sq += (value - summary.mean) * (value - summary.mean);
  if (values.size() > 1) summary.sd = std::sqrt(sum_sq / (count - 1.0));
  summary.median = quantile(values, 0.5);
  summary.p95 = quantile(values, 0.95);
  summary.max = *std::max_element(values.begin(), values.end());
  return summary;
}

}  // namespace mor
