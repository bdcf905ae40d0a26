// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace mor {

/// The value below which a `share` (0..1) of the samples lies, interpolated linearly between the
/// two nearest ranks, as NumPy and R (type 7) do by default. 0 without samples.
[[nodiscard]] inline double quantile(std::vector<double> samples, double share) {
  if (samples.empty()) return 0.0;
  std::sort(samples.begin(), samples.end());
  const double rank = share * static_cast<double>(samples.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(rank));
  const std::size_t above = std::min(below + 1, samples.size() - 1);
  return std::lerp(samples[below], samples[above], rank - static_cast<double>(below));
}

/// 0 without samples.
[[nodiscard]] inline double root_mean_square(const std::vector<double>& samples) {
  double squares = 0.0;
  for (const double sample : samples) squares += sample * sample;
  return samples.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(samples.size()));
}

/// The last `capacity` samples of something that is measured all the time.
class RollingWindow {
 public:
  explicit RollingWindow(std::size_t capacity) : capacity_(capacity) {}

  void add(double sample) {
    if (samples_.size() < capacity_) {
      samples_.push_back(sample);
    } else {
      samples_[next_ % capacity_] = sample;
    }
    ++next_;
  }

  [[nodiscard]] double median() const { return quantile(samples_, 0.5); }
  [[nodiscard]] double p95() const { return quantile(samples_, 0.95); }

 private:
  std::size_t capacity_;
  std::size_t next_ = 0;
  std::vector<double> samples_;
};

}  // namespace mor
