// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/calibration_desk.h"

#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/calibration_check.h"
#include "morgagni/camera/infrared_source.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::chrono::milliseconds kRetry{500};
constexpr Rgba8 kTakenColor{98, 211, 148, 255};
constexpr Rgba8 kSeenColor{94, 200, 216, 255};
constexpr Rgba8 kMovingColor{255, 193, 77, 255};

HttpResponse json_response(const Json& json) {
  return {.body = json.dump()};
}

HttpResponse refusal(const std::string& sentence) {
  return {.status = 400, .body = Json{{"error", sentence}}.dump()};
}

Json figures_json(const std::vector<std::pair<std::string, std::string>>& figures) {
  Json json = Json::array();
  for (const auto& [name, value] : figures) json.push_back({{"name", name}, {"value", value}});
  return json;
}

/// A filled circle.
void draw_dot(Image<Rgba8>& picture, const Eigen::Vector2d& px, double radius_px, Rgba8 color) {
  const int reach = static_cast<int>(std::ceil(radius_px));
  const int x0 = static_cast<int>(std::lround(px.x()));
  const int y0 = static_cast<int>(std::lround(px.y()));
  for (int y = y0 - reach; y <= y0 + reach; ++y) {
    for (int x = x0 - reach; x <= x0 + reach; ++x) {
      const Eigen::Vector2d from = Eigen::Vector2d(x, y) - px;
      if (picture.view().contains(x, y) && from.norm() <= radius_px) picture(x, y) = color;
    }
  }
}

class Desk final : public CalibrationDesk {
 public:
  Desk(std::unique_ptr<RangeCamera> camera, const CalibrationDeskOptions& options)
      : camera_(std::move(camera)),
        options_(options),
        device_id_(options.device_id.empty() ? camera_->device_id() : options.device_id),
        collector_(options.board, camera_->calibration(), options.collector) {}

  ~Desk() override {
    look_thread_ = {};
    solve_thread_ = {};
    server_.reset();
  }

  Result<void> begin() {
    MOR_TRY(server_, LiveServer::start(options_.server, routes()));
    look_thread_ = std::jthread([this](std::stop_token stop) { watch(stop); });
    return {};
  }

  std::uint16_t port() const override { return server_->port(); }

 private:
  std::vector<HttpRoute> routes() {
    const auto post = [](const char* path, auto handler) {
      return HttpRoute{"POST", path, [handler](const HttpRequest&) { return handler(); }};
    };
    return {{"GET",
             "/api/calibration",
             [this](const HttpRequest&) {
               const std::lock_guard lock(mutex_);
               return json_response(state());
             }},
            post("/api/calibration/take", [this] { return take(); }),
            post("/api/calibration/drop", [this] { return drop(); }),
            post("/api/calibration/restart", [this] { return restart(); }),
            post("/api/calibration/solve", [this] { return solve(); }),
            post("/api/calibration/save", [this] { return save(); })};
  }

  HttpResponse take() {
    const std::lock_guard lock(mutex_);
    if (result_) return refusal("begin again, or undo the last view, before you take more");
    is_wanted_ = true;
    return json_response({{"ok", true}});
  }

  HttpResponse drop() {
    const std::lock_guard lock(mutex_);
    if (collector_.views().empty()) return refusal("no view has been taken yet");
    collector_.drop_last();
    ++generation_;
    is_enough_ = false;
    forget_result();
    return json_response(state());
  }

  HttpResponse restart() {
    const std::lock_guard lock(mutex_);
    collector_ = ViewCollector(options_.board, camera_->calibration(), options_.collector);
    ++generation_;
    is_enough_ = false;
    forget_result();
    return json_response(state());
  }

  HttpResponse solve() {
    const std::lock_guard lock(mutex_);
    if (is_solving_) return refusal("the last calibration is still being computed");
    is_solving_ = true;
    forget_result();
    solve_thread_ = std::jthread([this, collector = collector_, of = generation_](std::stop_token) {
      auto result = collector.solve(options_.rig);
      const std::lock_guard done(mutex_);
      is_solving_ = false;
      if (of != generation_) {
        // Of views that have been dropped since.
      } else if (result) {
        result_ = *std::move(result);
      } else {
        problem_ = result.error().message;
      }
      server_->publish_status(state().dump());
    });
    return json_response(state());
  }

  HttpResponse save() {
    const std::lock_guard lock(mutex_);
    if (!result_) return refusal("there is no calibration to keep yet");
    if (device_id_.empty()) {
      return refusal("this device has no serial number: start with --device NAME to keep it");
    }
    const auto file = options_.store.save({.device_id = device_id_,
                                           .made_at = std::chrono::system_clock::now(),
                                           .made_by = "board",
                                           .figures = result_->figures(),
                                           .calibration = result_->calibration});
    if (!file) return {.status = 500, .body = Json{{"error", file.error().message}}.dump()};
    kept_ = file->string();
    return json_response(state());
  }

  /// Needs the lock.
  void forget_result() {
    result_.reset();
    problem_.clear();
    kept_.clear();
  }

  /// Needs the lock.
  Json state() const {
    const auto coverage = collector_.coverage();
    Json json = {{"board", to_string(options_.board)},
                 {"device", device_id_},
                 {"say", say_},
                 {"sees_board", sees_board_},
                 {"camera_error", camera_error_},
                 {"has_infrared", dynamic_cast<const InfraredSource*>(camera_.get()) != nullptr},
                 {"views", coverage.num_views},
                 {"wanted_views", options_.collector.wanted.in_hand},
                 {"views_on_wall", coverage.num_on_wall},
                 {"wanted_on_wall", options_.collector.wanted.on_wall},
                 {"parts", coverage.views_in_part},
                 {"distances", coverage.num_distances},
                 {"missing", coverage.missing},
                 {"solving", is_solving_},
                 {"problem", problem_},
                 {"kept", kept_}};
    if (const auto known = options_.store.newest(device_id_)) {
      json["in_use"] = fmt::format("{}, {}",
                                   known->calibration.origin,
                                   age_text(std::chrono::system_clock::now() - known->made_at));
    }
    if (!result_) return json;
    json["result"] = {{"figures", figures_json(result_->figures())}, {"remarks", result_->remarks}};
    if (const auto check =
            check_calibration(options_.board, collector_.views(), result_->calibration)) {
      json["result"]["check"] = figures_json(check->figures());
    }
    return json;
  }

  void watch(std::stop_token stop) {
    auto* infrared_source = dynamic_cast<InfraredSource*>(camera_.get());
    const ViewCollector::Infrared infrared = [&]() -> std::optional<Image<Rgb8>> {
      if (infrared_source == nullptr) return std::nullopt;
      auto picture = infrared_source->infrared_picture(stop);
      if (!picture) return std::nullopt;
      return *std::move(picture);
    };
    while (!stop.stop_requested()) {
      const auto frame = camera_->next_frame(stop);
      if (frame && !*frame) break;
      if (!frame) {
        complain(frame.error().message);
        std::unique_lock lock(retry_mutex_);
        std::condition_variable_any().wait_for(lock, stop, kRetry, [] { return false; });
        continue;
      }
      see(**frame, infrared);
    }
  }

  /// Needs the lock. Once there is enough, only what is asked for; while there is a result,
  /// nothing.
  Taking taking() const {
    if (is_solving_ || result_) return Taking::kNothing;
    if (is_wanted_) return Taking::kThisPose;
    return is_enough_ ? Taking::kNothing : Taking::kNewPoses;
  }

  void complain(const std::string& sentence) {
    const std::lock_guard lock(mutex_);
    camera_error_ = sentence;
    server_->publish_status(state().dump());
  }

  void see(const RgbdFrame& frame, const ViewCollector::Infrared& infrared) {
    LiveLook look;
    {
      const std::lock_guard lock(mutex_);
      camera_error_.clear();
      look = collector_.look(frame, taking(), infrared);
      if (look.was_taken) {
        is_wanted_ = false;
        is_enough_ = collector_.coverage().missing.empty();
        forget_result();
      }
      const bool is_news = look.was_taken || look.say != say_;
      say_ = look.say;
      sees_board_ = look.sighting.has_value();
      const auto now = std::chrono::steady_clock::now();
      if (is_news || now - published_at_ > kRetry) {
        published_at_ = now;
        server_->publish_status(state().dump());
      }
    }
    show(frame, look);
  }

  void show(const RgbdFrame& frame, const LiveLook& look) {
    picture_ = Image<Rgba8>(frame.color.width(), frame.color.height());
    for (std::size_t i = 0; i < picture_.size(); ++i) {
      const Rgb8& c = frame.color.data()[i];
      picture_.data()[i] = {c.r, c.g, c.b, 255};
    }
    if (look.sighting) {
      const Rgba8 color = look.was_taken || !look.is_new ? kTakenColor
                          : look.is_still                ? kSeenColor
                                                         : kMovingColor;
      const double radius_px = std::max(2.0, frame.color.width() / 210.0);
      for (const auto& corner : look.sighting->corners) {
        draw_dot(picture_, corner.px, radius_px, color);
      }
    }
    server_->show(picture_.view(), {frame.captured_at, R"({"mode":"calibration"})"});
  }

  const std::unique_ptr<RangeCamera> camera_;
  const CalibrationDeskOptions options_;
  const std::string device_id_;
  Image<Rgba8> picture_;

  std::mutex mutex_;  ///< Guards all below, to the blank line.
  ViewCollector collector_;
  bool is_wanted_ = false;  ///< The pose held now.
  std::string say_;
  bool sees_board_ = false;
  bool is_enough_ = false;
  std::string camera_error_;
  bool is_solving_ = false;
  int generation_ = 0;  ///< Of the views: one more when some are dropped.
  std::optional<RigCalibration> result_;
  std::string problem_;
  std::string kept_;
  std::chrono::steady_clock::time_point published_at_;

  std::mutex retry_mutex_;
  std::unique_ptr<LiveServer> server_;
  std::jthread solve_thread_;
  std::jthread look_thread_;
};

}  // namespace

Result<std::unique_ptr<CalibrationDesk>> CalibrationDesk::start(
    std::unique_ptr<RangeCamera> camera, const CalibrationDeskOptions& options) {
  MOR_CHECK(options.board.check());
  auto desk = std::make_unique<Desk>(std::move(camera), options);
  MOR_CHECK(desk->begin());
  return desk;
}

}  // namespace mor
