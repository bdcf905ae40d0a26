// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "coming_camera.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"
#include "morgagni/session/waiting_room.h"

#include "exit.h"

namespace mor {
namespace {

/// A camera that is there is open by then.
constexpr std::chrono::milliseconds kUsualTime{1000};

class ComingCamera {
 public:
  using Opened = Result<std::unique_ptr<RangeCamera>>;

  ComingCamera(const OpenCamera& open, const std::stop_token& stop)
      : forward_(stop, [this] { stop_.request_stop(); }),
        opener_([this, open, stopped = stop_.get_token()] {
          auto opened = open(stopped, [this](const auto& what) {
            const std::scoped_lock lock(mutex_);
            waits_for_ = what;
            changed_.notify_all();
          });
          const std::scoped_lock lock(mutex_);
          opened_ = std::move(opened);
          changed_.notify_all();
        }) {}
  ~ComingCamera() { stop_.request_stop(); }
  ComingCamera(const ComingCamera&) = delete;
  ComingCamera& operator=(const ComingCamera&) = delete;

  /// Until the camera is there or could not be opened, what is waited for is another than `said`,
  /// or `time` is over. @return Whether the camera is there or could not be opened.
  bool wait(std::chrono::milliseconds time, const std::string& said) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, time, [&] { return opened_ || waits_for_ != said; });
    return opened_.has_value();
  }
  std::string waits_for() {
    const std::scoped_lock lock(mutex_);
    return waits_for_;
  }
  /// After wait() was true.
  std::unique_ptr<RangeCamera> take_or_exit() {
    if (!*opened_ && opened_->error().code == ErrorCode::kCancelled) return nullptr;
    return value_or_exit(*std::move(opened_));
  }

 private:
  std::mutex mutex_;  ///< Guards the three below.
  std::condition_variable changed_;
  std::string waits_for_;
  std::optional<Opened> opened_;
  std::stop_source stop_;
  std::stop_callback<std::function<void()>> forward_;
  std::jthread opener_;
};

}  // namespace

std::unique_ptr<RangeCamera> wait_for_camera(const OpenCamera& open,
                                             const std::stop_token& stop,
                                             const SayWaiting& say) {
  ComingCamera coming(open, stop);
  if (coming.wait(kUsualTime, "")) return coming.take_or_exit();
  std::string said = coming.waits_for();
  say(said.empty() ? "waiting for the camera" : said);
  while (!coming.wait(std::chrono::hours(1), said)) {
    auto waits_for = coming.waits_for();
    if (waits_for == said) continue;
    said = std::move(waits_for);
    say(said);
  }
  return coming.take_or_exit();
}

std::unique_ptr<RangeCamera> wait_for_camera_on_page(const OpenCamera& open,
                                                     const std::stop_token& stop,
                                                     const std::string& page_title,
                                                     const std::string& camera_name,
                                                     const std::string& path,
                                                     LiveServerOptions& server) {
  std::unique_ptr<WaitingRoom> room;
  return wait_for_camera(open, stop, [&](const std::string& sentence) {
    if (!room) {
      room = value_or_exit(WaitingRoom::open(page_title, shown_camera_name(camera_name), server));
      server.port = room->port();
      fmt::print("{} waits for its camera at http://127.0.0.1:{}/{}  (stop with Ctrl-C)\n",
                 page_title,
                 server.port,
                 path);
      std::fflush(stdout);
    }
    room->say(sentence);
    log::info("waiting: {}", sentence);
  });
}

}  // namespace mor
