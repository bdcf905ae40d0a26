// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace mor::internal {

/// Scrambles a counter (Steele, Lea, Flood 2014, "SplitMix"): the same number for the same counter,
/// whoever asks first.
constexpr std::uint64_t scramble(std::uint64_t counter) {
  counter += 0x9E3779B97F4A7C15U;
  counter = (counter ^ (counter >> 30U)) * 0xBF58476D1CE4E5B9U;
  counter = (counter ^ (counter >> 27U)) * 0x94D049BB133111EBU;
  return counter ^ (counter >> 31U);
}

/// One row's random bits (Marsaglia 2003, xorshift64): two instructions a step, seeded by counter.
class RowRandom {
 public:
  RowRandom(std::uint64_t seed, std::uint64_t frame_id, std::uint64_t row)
      : state_(scramble(scramble(scramble(seed) ^ frame_id) ^ row) | 1U) {}

  std::uint64_t next() {
    state_ ^= state_ << 13U;
    state_ ^= state_ >> 7U;
    state_ ^= state_ << 17U;
    return state_;
  }

 private:
  std::uint64_t state_;
};

/// In [0, 1).
constexpr double to_unit(std::uint64_t bits) {
  return static_cast<double>(bits >> 11U) * 0x1.0p-53;
}

/// A few draws in order, from a counter of their own.
class Draws {
 public:
  explicit Draws(std::uint64_t counter) : counter_(counter) {}
  /// Even over [least, most).
  double operator()(double least, double most) {
    return least + (most - least) * to_unit(scramble(counter_++));
  }
  /// Even over 0..count - 1.
  std::size_t choice(std::size_t count) {
    return static_cast<std::size_t>(to_unit(scramble(counter_++)) * static_cast<double>(count));
  }

 private:
  std::uint64_t counter_;
};

/// The quantiles of the normal distribution at 4096 even steps: 12 random bits look up one draw.
class NormalTable {
 public:
  NormalTable() {
    // Sum of the density over a fine grid, inverted: good to 1e-4, once a program.
    constexpr int kSteps = 65536;
    constexpr double kReach = 4.5;
    double below = 0.0;
    std::size_t filled = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double x = -kReach + 2.0 * kReach * (i + 0.5) / kSteps;
      below += std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi) * 2.0 * kReach / kSteps;
      while (filled < values_.size() && (filled + 0.5) / values_.size() <= below) {
        values_[filled++] = static_cast<float>(x);
      }
    }
    for (; filled < values_.size(); ++filled) values_[filled] = static_cast<float>(kReach);
  }
  /// Standard normal, from the lowest 12 of `bits`.
  [[nodiscard]] float operator()(std::uint64_t bits) const { return values_[bits & 0xFFFU]; }

 private:
  std::array<float, 4096> values_{};
};

}  // namespace mor::internal
