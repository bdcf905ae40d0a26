// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "morgagni/core/statistics.h"

namespace mor {

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
