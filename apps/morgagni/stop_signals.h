// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stop_token>
#include <thread>

namespace mor {

/// Ctrl-C and SIGTERM as a stop that long work can end by. To be made before any other thread, so
/// that none but its own takes the signals.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();

  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }
  /// Returns once a signal has come.
  void wait() const;

 private:
  std::stop_source stop_;
  std::jthread waiter_;
};

}  // namespace mor
