// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "stop_signals.h"

#include <condition_variable>
#include <csignal>
#include <mutex>

namespace mor {
namespace {

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

/// As the system does it by itself: the shell sees that it was the signal.
void end_by(int signal) {
  std::signal(signal, SIG_DFL);
  const auto signals = stop_signals();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  std::raise(signal);
}

}  // namespace

StopSignals::StopSignals() {
  const auto signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  waiter_ = std::jthread([this] {
    const auto awaited = stop_signals();
    int signal = 0;
    sigwait(&awaited, &signal);
    signal_ = signal;
    stop_.request_stop();
    if (num_mortal_ > 0) end_by(signal);
  });
}

StopSignals::~StopSignals() {
  // Lets the waiter go; where it is gone already, the signal stays pending with a thread that is
  // no more.
  if (!stop_.stop_requested()) pthread_kill(waiter_.native_handle(), SIGTERM);
}

StopSignals::Mortal::Mortal(StopSignals& signals) : signals_(signals) {
  ++signals.num_mortal_;
  if (const int signal = signals.signal_) end_by(signal);
}

void StopSignals::wait() const {
  std::mutex mutex;
  std::condition_variable_any nobody_notifies;
  std::unique_lock lock(mutex);
  nobody_notifies.wait(lock, stop_.get_token(), [] { return false; });
}

}  // namespace mor
