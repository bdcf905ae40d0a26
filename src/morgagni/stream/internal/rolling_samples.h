// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace mor::internal {

/// The last 60 values, for figures that follow what happens now.
class RollingSamples {
 public:
  void add(double value) {
    values_[next_] = value;
    next_ = (next_ + 1) % kSize;
    count_ = std::min(count_ + 1, kSize);
  }

  /// The value that a share of `fraction` does not exceed (nearest rank); 0 while there is none.
  [[nodiscard]] double quantile(double fraction) const {
    if (count_ == 0) return 0.0;
    auto sorted = values_;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count_);
    const double rank = std::ceil(fraction * static_cast<double>(count_));
    const auto idx = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
    std::nth_element(sorted.begin(), sorted.begin() + idx, end);
    return sorted[static_cast<std::size_t>(idx)];
  }

 private:
  static constexpr std::size_t kSize = 60;
  std::array<double, kSize> values_{};
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

}  // namespace mor::internal
