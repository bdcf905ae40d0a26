// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <thread>

typedef struct _GMainContext GMainContext;  // NOLINT(modernize-use-using): as GLib declares them.
typedef struct _GMainLoop GMainLoop;        // NOLINT(modernize-use-using)

namespace mor {

/// A GLib main loop in a thread of its own. Everything that libsoup calls back runs in it.
class MainLoop {
 public:
  MainLoop();
  ~MainLoop();
  MainLoop(const MainLoop&) = delete;
  MainLoop& operator=(const MainLoop&) = delete;

  /// Starts the thread; whatever was attached to context() before comes to life now.
  void run();

  /// Ends the thread after what is posted before. Posted work that never ran is dropped.
  void stop();

  /// Runs `work` in the loop, in order of the calls. Any thread.
  void post(std::function<void()> work);

  /// Runs `work` in the loop and waits for its end. Not from the loop itself.
  void post_and_wait(const std::function<void()>& work);

  /// Calls `work` again and again until the loop ends.
  void every(std::chrono::milliseconds period, std::function<void()> work);

  [[nodiscard]] GMainContext* context() const { return context_; }

 private:
  GMainContext* context_;
  GMainLoop* loop_;
  std::jthread thread_;
};

}  // namespace mor
