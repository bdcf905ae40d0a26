// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
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

  /// Does work that looks at no token and leaves nothing behind when it is killed: meanwhile a
  /// signal ends the process by itself, as if nobody waited for it.
  template <class Work>
  [[nodiscard]] auto at_once(const Work& work) {
    const Mortal mortal(*this);
    return work();
  }

 private:
  struct Mortal {
    explicit Mortal(StopSignals& signals);
    ~Mortal() { --signals_.num_mortal_; }
    Mortal(const Mortal&) = delete;
    Mortal& operator=(const Mortal&) = delete;

   private:
    StopSignals& signals_;
  };

  std::stop_source stop_;
  std::atomic<int> num_mortal_{0};
  std::atomic<int> signal_{0};  ///< The one that came.
  std::jthread waiter_;
};

}  // namespace mor
