// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace mor::internal {

/// Eight numbers that are computed with at once (GCC's and Clang's vector extension). Comparisons
/// give masks, and `mask ? a : b` chooses lane by lane.
inline constexpr int kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using IntLanes = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

[[nodiscard]] inline Lanes min_of(const Lanes& a, const Lanes& b) {
  return a < b ? a : b;
}
[[nodiscard]] inline Lanes max_of(const Lanes& a, const Lanes& b) {
  return a > b ? a : b;
}

/// In the lanes' order.
[[nodiscard]] inline double sum_of(const Lanes& lanes) {
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += static_cast<double>(lanes[i]);
  return sum;
}

}  // namespace mor::internal
