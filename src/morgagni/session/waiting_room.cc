// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/waiting_room.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "morgagni/core/printable_text.h"
#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

constexpr std::chrono::milliseconds kStatusPeriod{400};

class Room final : public WaitingRoom {
 public:
  Room(std::unique_ptr<LiveServer> server, std::string case_name, std::string camera_name)
      : server_(std::move(server)),
        case_name_(std::move(case_name)),
        camera_name_(std::move(camera_name)),
        status_thread_([this](const std::stop_token& stop) { report(stop); }) {}

  void say(const std::string& sentence) override {
    const std::scoped_lock lock(mutex_);
    sentence_ = printable_text(sentence);
    changed_ = true;
    tick_.notify_all();
  }

  std::uint16_t port() const override { return server_->port(); }

 private:
  void report(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      changed_ = false;
      server_->publish_status(api::Json{
          {"waiting_for_camera", sentence_}, {"case", case_name_}, {"camera", camera_name_}}
                                  .dump());
      tick_.wait_for(lock, stop, kStatusPeriod, [this] { return changed_; });
    }
  }

  std::unique_ptr<LiveServer> server_;
  const std::string case_name_;
  const std::string camera_name_;
  std::mutex mutex_;  ///< Guards the two below.
  std::string sentence_ = "waiting for the camera";
  bool changed_ = false;
  std::condition_variable_any tick_;
  std::jthread status_thread_;
};

}  // namespace

Result<std::unique_ptr<WaitingRoom>> WaitingRoom::open(const std::string& case_name,
                                                       const std::string& camera_name,
                                                       const LiveServerOptions& server) {
  MOR_TRY(auto started, LiveServer::start(server, {}));
  return std::make_unique<Room>(
      std::move(started), printable_text(case_name), printable_text(camera_name));
}

}  // namespace mor
