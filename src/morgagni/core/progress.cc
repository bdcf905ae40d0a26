// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/progress.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

class ConsoleBar {
 public:
  void show(std::string_view stage, double fraction) {
    if (stage != stage_) {
      stage_ = stage;
      started_ = Clock::now();
      last_drawn_ = {};
    }
    const auto now = Clock::now();
    const bool done = fraction >= 1.0;
    const bool redraw = is_terminal_ && now - last_drawn_ > std::chrono::milliseconds(80);
    if (!done && !redraw) return;
    last_drawn_ = now;
    const double seconds = std::chrono::duration<double>(now - started_).count();
    constexpr int kWidth = 24;
    const int filled = static_cast<int>(kWidth * (done ? 1.0 : fraction));
    const std::string line = fmt::format("{:<28} [{:<{}}] {:3.0f} % {:6.1f} s",
                                         stage_,
                                         std::string(static_cast<std::size_t>(filled), '#'),
                                         kWidth,
                                         100.0 * (done ? 1.0 : fraction),
                                         seconds);
    fmt::print(stderr, "{}{}{}", is_terminal_ ? "\r" : "", line, done ? "\n" : "");
    std::fflush(stderr);
  }

 private:
  const bool is_terminal_ = isatty(STDERR_FILENO) == 1;
  std::string stage_;
  Clock::time_point started_;
  Clock::time_point last_drawn_;
};

}  // namespace

Progress console_progress() {
  auto bar = std::make_shared<ConsoleBar>();
  return [bar](std::string_view stage, double fraction) { bar->show(stage, fraction); };
}

}  // namespace mor
