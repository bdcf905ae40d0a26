// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace mor {

/// Hands the newest value from one thread to another. A value nobody took is dropped for the next
/// one and counted: a slow stage falls behind by frames, never by time.
template <class T>
class LatestSlot {
 public:
  void put(T value) {
    {
      const std::lock_guard lock(mutex_);
      if (value_) ++num_dropped_;
      value_ = std::move(value);
    }
    filled_.notify_one();
  }

  /// Waits for a value; none once `stop` is requested.
  [[nodiscard]] std::optional<T> take(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    if (!filled_.wait(lock, stop, [this] { return value_.has_value(); })) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

  /// The same, but none also when nothing came for `patience`.
  [[nodiscard]] std::optional<T> take(std::stop_token stop, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!filled_.wait_for(lock, stop, patience, [this] { return value_.has_value(); })) {
      return std::nullopt;
    }
    return std::exchange(value_, std::nullopt);
  }

  [[nodiscard]] std::uint64_t num_dropped() const {
    const std::lock_guard lock(mutex_);
    return num_dropped_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable_any filled_;
  std::optional<T> value_;
  std::uint64_t num_dropped_ = 0;
};

}  // namespace mor
