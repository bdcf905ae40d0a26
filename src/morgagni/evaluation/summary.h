// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace mor {

/// What a table says of a sample. All 0 for an empty one.
struct Summary {
  double mean = 0.0;
  double sd = 0.0;  ///< Of the sample: divided by n - 1; 0 for a single value.
  double median = 0.0;
  double p95 = 0.0;
  double max = 0.0;
};

[[nodiscard]] Summary summarize(const std::vector<double>& values);

}  // namespace mor
