// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <deque>

namespace mor {

/// Events a second over the last two seconds.
class FrameRate {
 public:
  using Clock = std::chrono::steady_clock;

  void count(Clock::time_point now) {
    times_.push_back(now);
    while (now - times_.front() > kWindow) times_.pop_front();
  }

  [[nodiscard]] double per_second(Clock::time_point now) const {
    std::size_t recent = 0;
    for (const auto time : times_) recent += now - time <= kWindow ? 1 : 0;
    return static_cast<double>(recent) / std::chrono::duration<double>(kWindow).count();
  }

 private:
  static constexpr std::chrono::seconds kWindow{2};
  std::deque<Clock::time_point> times_;
};

}  // namespace mor
