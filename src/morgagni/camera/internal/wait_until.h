// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>

namespace mor::internal {

/// Sleeps until `due`; false as soon as `stop` is requested.
inline bool wait_until(std::chrono::steady_clock::time_point due, std::stop_token stop) {
  std::mutex mutex;
  std::condition_variable_any nobody_notifies;
  std::unique_lock lock(mutex);
  nobody_notifies.wait_until(lock, stop, due, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace mor::internal
