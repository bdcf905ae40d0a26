// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_session.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "morgagni/core/folder_lock.h"
#include "morgagni/core/printable_text.h"
#include "morgagni/session/routes/api_json.h"
#include "morgagni/session/routes/documents_routes.h"
#include "morgagni/session/routes/findings_routes.h"
#include "morgagni/session/routes/live_api.h"
#include "morgagni/session/routes/recorder_routes.h"
#include "morgagni/session/routes/recording_routes.h"
#include "morgagni/session/routes/self_calibration_routes.h"
#include "morgagni/session/routes/still_routes.h"
#include "morgagni/session/routes/texture_routes.h"

namespace mor {
namespace {

constexpr std::chrono::milliseconds kStatusPeriod{200};

class Session final : public LiveSession {
 public:
  Session(std::shared_ptr<LiveLoop> loop,
          std::unique_ptr<LiveServer> server,
          std::optional<FolderLock> in_use,
          std::shared_ptr<Recorder> recorder,
          RgbdCalibration calibration,
          const LiveSessionOptions& options)
      : in_use_(std::move(in_use)),
        loop_(std::move(loop)),
        server_(std::move(server)),
        recorder_(std::move(recorder)),
        method_(to_string(options.loop.registration.method)),
        camera_name_(printable_text(options.camera_name)),
        calibration_(std::move(calibration)),
        status_thread_([this](std::stop_token stop) { report(stop); }) {}

  std::uint16_t port() const override { return server_->port(); }
  LiveStatus status() const override { return loop_->status(); }
  LiveServerStats stream_stats() const override { return server_->stats(); }

 private:
  void report(std::stop_token stop) {
    std::mutex mutex;
    std::condition_variable_any tick;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      const auto status = loop_->status();
      const auto& frame = status.last.frame;
      const auto origin = calibration_origin(frame ? *frame->calibration : calibration_,
                                             camera_name_,
                                             std::chrono::system_clock::now());
      server_->publish_status(
          status_json(status, loop_->view(), server_->stats(), method_, camera_name_, origin));
      tick.wait_for(lock, stop, kStatusPeriod, [] { return false; });
    }
  }

  std::optional<FolderLock> in_use_;
  // The loop draws into the server and the server's routes command the loop. The routes hold the
  // loop, so the loop's threads are stopped first, by ~Session.
  std::shared_ptr<LiveLoop> loop_;
  std::unique_ptr<LiveServer> server_;
  std::shared_ptr<Recorder> recorder_;
  std::string_view method_;
  std::string camera_name_;
  RgbdCalibration calibration_;  ///< Until the first frame has come.
  std::jthread status_thread_;

 public:
  ~Session() override {
    status_thread_ = {};
    recorder_->close();
    loop_->stop();
  }
};

}  // namespace

Result<std::unique_ptr<LiveSession>> LiveSession::start(Case body,
                                                        std::unique_ptr<RangeCamera> camera,
                                                        const LiveSessionOptions& options) {
  std::optional<FolderLock> in_use;
  if (!body.folder.empty()) {
    MOR_TRY(in_use,
            FolderLock::take(body.folder,
                             FolderLock::Kind::kShared,
                             body.folder.string() + " is being prepared: start again after that"));
  }
  const std::string device_id = camera->device_id();
  const auto shared_body = std::make_shared<const Case>(std::move(body));
  MOR_TRY(std::shared_ptr<LiveLoop> loop,
          LiveLoop::create(shared_body, std::move(camera), options.loop));
  const auto desk = std::make_shared<FindingsDesk>(shared_body, loop);
  loop->mark([desk = desk.get()](const ShownPicture& shown) { return desk->marks(shown); });
  const auto texture = std::make_shared<TextureRecorder>(shared_body);
  loop->observe([texture](const TrackedFrame& tracked) { texture->look(tracked); });
  loop->take_fused_from([texture] { return texture->texture(); });
  const auto recorder = std::make_shared<Recorder>(
      shared_body,
      [loop] { return loop->calibration(); },
      [loop] { return loop->skin(); },
      printable_text(options.camera_name));
  const auto recording = make_session_recorder(*shared_body, printable_text(options.camera_name));
  loop->observe([recording](const TrackedFrame& tracked) { recording->see(tracked); });
  const RgbdCalibration own_calibration = *loop->calibration();
  const CalibrationInUse calibration{[loop] { return loop->calibration(); },
                                     [loop] { return loop->skin(); },
                                     [loop](auto next, auto skin, double bias_mm) {
                                       return loop->use_calibration(
                                           std::move(next), std::move(skin), bias_mm);
                                     },
                                     [loop](double bias_mm) { loop->expect_bias(bias_mm); }};
  const auto hindrance = [recording, recorder] {
    const bool goes_on =
        recording->state().is_recording || recorder->status().state != RecorderState::kIdle;
    return std::string(goes_on ? "a recording goes on under the calibration in use: stop it first"
                               : "");
  };
  const auto calibrator = std::make_shared<SelfCalibrator>(
      shared_body, calibration, device_id, CalibrationStore(), hindrance);
  loop->observe(
      [calibrator = calibrator.get()](const auto& tracked) { calibrator->look(tracked); });
  // Each topic has its routes in a file of its own and joins the others with one line.
  std::vector<HttpRoute> routes = api::joined({
      make_live_routes(shared_body, loop, options.loop.placement),
      make_ct_routes(options.cts),
      make_findings_routes(desk),
      make_recording_routes(recording),
      make_texture_routes(texture),
      make_recorder_routes(recorder),
      make_self_calibration_routes(calibrator),
      make_still_routes(shared_body, loop),
      make_documents_routes(shared_body, options.server.web_root),
  });
  MOR_TRY(auto server, LiveServer::start(options.server, std::move(routes)));
  MOR_CHECK(
      loop->run([sink = server.get()](ImageView<const Rgba8> picture, const PictureInfo& info) {
        sink->show(picture, info);
      }));
  recorder->run(*server);
  return std::make_unique<Session>(
      std::move(loop), std::move(server), std::move(in_use), recorder, own_calibration, options);
}

}  // namespace mor
