// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/live_server.h"

#include <mutex>
#include <utility>

#include "morgagni/core/main_loop.h"
#include "morgagni/stream/internal/gst_parts.h"
#include "morgagni/stream/internal/http_server.h"
#include "morgagni/stream/internal/video_encoder.h"
#include "morgagni/stream/internal/video_recorder.h"
#include "morgagni/stream/internal/viewer_hub.h"

namespace mor {

namespace {

using std::chrono::milliseconds;

class LiveServerOnGlib : public LiveServer {
 public:
  explicit LiveServerOnGlib(int max_viewers) : viewers_(main_loop_, max_viewers) {}

  ~LiveServerOnGlib() override {
    if (is_running_) {
      main_loop_.post_and_wait([this] {
        viewers_.remove_all();
        http_.reset();
      });
      main_loop_.stop();
    }
  }

  LiveServerOnGlib(const LiveServerOnGlib&) = delete;
  LiveServerOnGlib& operator=(const LiveServerOnGlib&) = delete;

  Result<void> begin(const LiveServerOptions& options, std::vector<HttpRoute> routes) {
    const auto to_viewers = [this](const internal::EncodedPicture& picture) {
      viewers_.send(picture);
      if (const auto recorder = recorder_of_now()) recorder->add(picture);
    };
    MOR_TRY(encoder_, internal::VideoEncoder::create(options.bitrate_kbps, to_viewers));
    viewers_.set_encoder(encoder_.get());
    http_ = std::make_unique<internal::HttpServer>(viewers_, options.web_root, std::move(routes));
    // libsoup attaches its socket to the context that is the default when it listens.
    g_main_context_push_thread_default(main_loop_.context());
    const auto listening = http_->listen(options.port);
    g_main_context_pop_thread_default(main_loop_.context());
    MOR_CHECK(listening);
    port_ = http_->port();
    main_loop_.every(milliseconds(1000), [this] { viewers_.remove_gone(); });
    main_loop_.every(milliseconds(2000), [this] {
      if (http_) http_->events().send_heartbeat();
    });
    main_loop_.run();
    is_running_ = true;
    return {};
  }

  void show(ImageView<const Rgba8> picture, const PictureInfo& info) override {
    encoder_->show(picture, info);
  }

  void publish_status(std::string json) override {
    main_loop_.post([this, json = std::move(json)] {
      if (http_) http_->events().publish(json);
    });
  }

  Result<void> start_video(const VideoFiles& files) override {
    if (const auto recorder = recorder_of_now(); recorder && recorder->status().is_running)
      return make_error(ErrorCode::kInvalidArgument, "a video is being recorded already");
    MOR_TRY(std::shared_ptr<internal::VideoRecorder> made, internal::VideoRecorder::create(files));
    {
      const std::lock_guard lock(recorder_mutex_);
      recorder_ = std::move(made);
    }
    encoder_->request_key_picture();
    return {};
  }

  [[nodiscard]] VideoStatus video() const override {
    const auto recorder = recorder_of_now();
    return recorder ? recorder->status() : VideoStatus{};
  }

  VideoStatus stop_video() override {
    const auto recorder = recorder_of_now();
    if (!recorder) return {};
    recorder->finish();
    return recorder->status();
  }

  [[nodiscard]] LiveServerStats stats() const override {
    LiveServerStats stats;
    encoder_->add_to(stats);
    stats.num_viewers = viewers_.num_viewers();
    return stats;
  }

  [[nodiscard]] std::uint16_t port() const override { return port_; }

 private:
  std::shared_ptr<internal::VideoRecorder> recorder_of_now() const {
    const std::lock_guard lock(recorder_mutex_);
    return recorder_;
  }

  MainLoop main_loop_;
  internal::ViewerHub viewers_;
  mutable std::mutex recorder_mutex_;
  std::shared_ptr<internal::VideoRecorder> recorder_;
  std::unique_ptr<internal::VideoEncoder> encoder_;
  std::unique_ptr<internal::HttpServer> http_;  ///< Of the main loop, once that runs.
  std::uint16_t port_ = 0;
  bool is_running_ = false;
};

}  // namespace

Result<void> LiveServerOptions::check() const {
  const auto refuse = [](std::string sentence) {
    return make_error(ErrorCode::kInvalidArgument, std::move(sentence));
  };
  if (bitrate_kbps < 100 || bitrate_kbps > 50000) {
    return refuse("bitrate_kbps must be in 100..50000, got " + std::to_string(bitrate_kbps));
  }
  if (max_viewers < 1 || max_viewers > 64) {
    return refuse("max_viewers must be in 1..64, got " + std::to_string(max_viewers));
  }
  if (std::error_code error; !std::filesystem::is_regular_file(web_root / "index.html", error)) {
    return make_error(ErrorCode::kNotFound, "the page is not built: run ./run --build");
  }
  return {};
}

Result<std::unique_ptr<LiveServer>> LiveServer::start(const LiveServerOptions& options,
                                                      std::vector<HttpRoute> routes) {
  MOR_CHECK(options.check());
  MOR_CHECK(internal::check_gstreamer());
  auto server = std::make_unique<LiveServerOnGlib>(options.max_viewers);
  MOR_CHECK(server->begin(options, std::move(routes)));
  return server;
}

}  // namespace mor
