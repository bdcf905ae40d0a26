// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// A server with a moving test pattern and a session that only remembers what it was told: the
// page's tests drive the real stream with it, in states that a real session reaches seldom.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <iostream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "morgagni/core/image_png.h"
#include "morgagni/core/log.h"
#include "morgagni/stream/live_server.h"
#include "morgagni/stream/testing/test_pattern.h"

namespace {

using mor::HttpRequest;
using mor::HttpResponse;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

std::atomic<bool> stop_requested = false;

HttpResponse ok(const json& body) {
  return {.body = body.dump()};
}

HttpResponse refuse(int status, const std::string& sentence) {
  return {.status = status, .body = json{{"error", sentence}}.dump()};
}

HttpResponse png(const std::vector<std::byte>& bytes) {
  return {.content_type = "image/png",
          .body = std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())};
}

double number(const HttpRequest& request, const std::string& name, double otherwise) {
  const auto found = request.query.find(name);
  return found != request.query.end() ? std::strtod(found->second.c_str(), nullptr) : otherwise;
}

/// A lit ellipsoid that turns: enough to tap on.
mor::Image<mor::Rgb8> draw_body(double yaw, double pitch, double zoom, int width, int height) {
  mor::Image<mor::Rgb8> picture(width, height, {18, 22, 28});
  const double radius_px = zoom * 0.4 * height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x - width / 2.0) / (0.7 * radius_px);
      const double v = (y - height / 2.0) / radius_px;
      const double w_sq = 1.0 - u * u - v * v;
      if (w_sq < 0.0) continue;
      const double w = std::sqrt(w_sq);
      const double longitude = std::atan2(u, w) + yaw;
      const double latitude = std::asin(std::clamp(v, -1.0, 1.0)) + pitch;
      const bool is_dark = std::sin(6 * longitude) * std::sin(6 * latitude) < -0.75;
      const auto shade = [&](double base) {
        return static_cast<std::uint8_t>(base * (0.35 + 0.65 * w) * (is_dark ? 0.8 : 1.0));
      };
      picture(x, y) = {shade(222), shade(184), shade(160)};
    }
  }
  return picture;
}

/// What a session would answer, without a camera, a CT or a body.
class PretendedSession {
 public:
  std::vector<mor::HttpRoute> routes() {
    using Method = HttpResponse (PretendedSession::*)(const HttpRequest&);
    const auto route = [this](std::string method, std::string path, Method handler) {
      return mor::HttpRoute{
          std::move(method), std::move(path), [this, handler](const HttpRequest& request) {
            const std::lock_guard lock(mutex_);
            return (this->*handler)(request);
          }};
    };
    return {
        route("GET", "/api/case", &PretendedSession::get_case),
        route("POST", "/api/view", &PretendedSession::set_view),
        route("GET", "/api/texture", &PretendedSession::get_texture),
        route("GET", "/api/cts", &PretendedSession::get_cts),
        route("GET", "/api/self-calibration", &PretendedSession::get_self_calibration),
        route("POST", "/api/start/automatic", &PretendedSession::search),
        route("POST", "/api/touch", &PretendedSession::touch),
        route("POST", "/api/start/placement", &PretendedSession::place),
        route("POST", "/api/landmarks/begin", &PretendedSession::begin_landmarks),
        route("POST", "/api/landmarks/ct", &PretendedSession::pick_ct),
        route("POST", "/api/landmarks/live", &PretendedSession::pick_live),
        route("POST", "/api/landmarks/solve", &PretendedSession::solve),
        route("POST", "/api/landmarks/accept", &PretendedSession::accept),
        route("POST", "/api/landmarks/cancel", &PretendedSession::cancel),
        route("POST", "/api/freeze", &PretendedSession::freeze),
        route("POST", "/api/pretend", &PretendedSession::pretend),
        route("GET", "/api/skin-view.png", &PretendedSession::skin_view),
        route("GET", "/api/snapshot.png", &PretendedSession::snapshot),
    };
  }

  std::string status(const mor::LiveServerStats& stats) {
    const std::lock_guard lock(mutex_);
    json status = status_;
    status["view"] = view_;
    status["viewers"] = stats.num_viewers;
    status["latency_ms"] = {{"median", stats.capture_to_encoded_ms},
                            {"p95", stats.capture_to_encoded_p95_ms}};
    status["stage_ms"]["encode"] = stats.encode_ms;
    status["frames"]["dropped"] = stats.num_dropped;
    return status.dump();
  }

  /// How the next picture is to be made; none while the picture stands.
  struct Wish {
    std::string state;
    int width = 640;
    int height = 480;
    bool stands = false;
  };
  Wish wish() {
    const std::lock_guard lock(mutex_);
    return {status_["state"], width_, height_, stalls_ || status_["frozen"].get<bool>()};
  }

  void remember(mor::ImageView<const mor::Rgba8> picture) {
    const std::lock_guard lock(mutex_);
    last_picture_ = mor::Image<mor::Rgba8>(picture.width(), picture.height());
    for (int y = 0; y < picture.height(); ++y) {
      std::copy_n(picture.row(y), picture.width(), &last_picture_(0, y));
    }
  }

 private:
  HttpResponse get_case(const HttpRequest&) {
    return ok(
        {{"name", "Pretended body 17"},
         {"structures",
          {{{"name", "bone"}, {"color", "#ede3c7"}}, {{"name", "vessels"}, {"color", "#d6453d"}}}},
         {"has_ct", true},
         {"skin_radius_mm", 200.0},
         {"start_options", {{"distance_mm", 600}, {"min", 300}, {"max", 1000}}},
         {"version", "0.1.0"}});
  }
  HttpResponse set_view(const HttpRequest& request) {
    const auto change = json::parse(request.body, nullptr, false);
    if (!change.is_object()) return refuse(400, "the body must be a JSON object");
    view_.merge_patch(change);
    return ok(view_);
  }
  HttpResponse get_cts(const HttpRequest&) { return ok({{"names", json::array()}, {"shown", ""}}); }
  HttpResponse get_self_calibration(const HttpRequest&) {
    return ok({{"phase", "gathering"},
               {"views", 0},
               {"wanted_views", 60},
               {"views_in_part", json::array({0, 0, 0, 0, 0, 0, 0, 0, 0})},
               {"missing", json::array()},
               {"found", nullptr},
               {"applied", nullptr},
               {"device", nullptr},
               {"problem", nullptr}});
  }
  HttpResponse get_texture(const HttpRequest&) {
    return ok({{"ready", false},
               {"recording", false},
               {"coverage", 0.0},
               {"frames", 0},
               {"last", nullptr},
               {"version", 0},
               {"saving", false},
               {"saved", false},
               {"problem", nullptr}});
  }
  HttpResponse search(const HttpRequest&) {
    status_.update({{"starting", "automatic"},
                    {"state", "waiting"},
                    {"search", {{"searching", true}, {"last", nullptr}, {"reason", ""}}}});
    return ok(json::object());
  }
  HttpResponse touch(const HttpRequest& request) {
    const auto point = json::parse(request.body, nullptr, false);
    if (!point.is_object()) return refuse(400, "the body must be a JSON object");
    if (point.value("x", 0.0) < 20) return refuse(422, "the camera has no depth at that point");
    return ok({{"ct_mm", {-12.0, 84.0, 210.0}}, {"bound_mm", 1.3}, {"state", status_["state"]}});
  }
  HttpResponse place(const HttpRequest& request) {
    const auto placement = json::parse(request.body, nullptr, false);
    if (!placement.is_object()) return refuse(400, "the body must be a JSON object");
    status_["starting"] = "placement";
    status_["state"] = "waiting";
    return ok(json::object());
  }
  HttpResponse begin_landmarks(const HttpRequest&) {
    status_["starting"] = "landmarks";
    status_["frozen"] = true;
    return ok(json::object());
  }
  HttpResponse pick_ct(const HttpRequest& request) {
    const auto pick = json::parse(request.body, nullptr, false);
    if (!pick.is_object()) return refuse(400, "the body must be a JSON object");
    const double u = pick.value("x", 0.0) / pick.value("width", 1.0) - 0.5;
    const double v = pick.value("y", 0.0) / pick.value("height", 1.0) - 0.5;
    if (std::hypot(u, v) > 0.42) return refuse(422, "there is no skin at that point");
    return ok({{"ct_mm", {500.0 * u, 120.0, 400.0 * v}}});
  }
  HttpResponse pick_live(const HttpRequest& request) {
    const auto pick = json::parse(request.body, nullptr, false);
    if (!pick.is_object()) return refuse(400, "the body must be a JSON object");
    const double x = pick.value("x", 0.0);
    const double y = pick.value("y", 0.0);
    if (x < 20) return refuse(422, "the camera has no depth at that point");
    return ok({{"depth_mm", {x - 320, y - 240, 700.0}}});
  }
  HttpResponse solve(const HttpRequest& request) {
    const auto pairs = json::parse(request.body, nullptr, false);
    if (!pairs.is_object() || !pairs.contains("pairs")) return refuse(400, "there are no pairs");
    if (pairs["pairs"].size() < 3) {
      return refuse(422,
                    "at least 3 pairs are needed, got " + std::to_string(pairs["pairs"].size()));
    }
    json residuals = json::array();
    for (std::size_t i = 0; i < pairs["pairs"].size(); ++i) residuals.push_back(1.1 + 0.9 * i);
    return ok({{"fre_mm", 2.4}, {"residuals_mm", residuals}});
  }
  HttpResponse accept(const HttpRequest& request) {
    if (const auto solved = solve(request); solved.status != 200) return solved;
    status_.update({{"starting", nullptr}, {"frozen", false}, {"state", "tracking"}});
    return ok(json::object());
  }
  HttpResponse cancel(const HttpRequest&) {
    status_.update({{"starting", nullptr}, {"frozen", false}});
    return ok(json::object());
  }
  HttpResponse freeze(const HttpRequest& request) {
    const auto wish = json::parse(request.body, nullptr, false);
    if (!wish.is_object()) return refuse(400, "the body must be a JSON object");
    status_["frozen"] = wish.value("frozen", false);
    return ok(json::object());
  }
  /// For the tests: any member of the status, and `stalls`, `width`, `height` of the picture.
  HttpResponse pretend(const HttpRequest& request) {
    auto change = json::parse(request.body, nullptr, false);
    if (!change.is_object()) return refuse(400, "the body must be a JSON object");
    stalls_ = change.value("stalls", stalls_);
    width_ = change.value("width", width_);
    height_ = change.value("height", height_);
    for (const auto* name : {"stalls", "width", "height"}) change.erase(name);
    status_.update(change);
    return ok(json::object());
  }
  HttpResponse skin_view(const HttpRequest& request) {
    const auto body = draw_body(number(request, "yaw", 0),
                                number(request, "pitch", 0),
                                number(request, "zoom", 1),
                                static_cast<int>(number(request, "width", 640)),
                                static_cast<int>(number(request, "height", 480)));
    return png(mor::encode_png(body.view()));
  }
  HttpResponse snapshot(const HttpRequest&) {
    return png(mor::encode_png(std::as_const(last_picture_).view()));
  }

  std::mutex mutex_;
  int width_ = 640;
  int height_ = 480;
  bool stalls_ = false;
  mor::Image<mor::Rgba8> last_picture_;
  json view_ = {{"opacity", 0.75},
                {"hole_radius", 0.35},
                {"hole_x", 0.5},
                {"hole_y", 0.5},
                {"hands_in_front", true},
                {"outlines", false},
                {"structures", {{"bone", true}, {"vessels", true}}},
                {"structure_opacity", {{"bone", 1.0}, {"vessels", 1.0}}},
                {"slice", "none"},
                {"slice_position", 0.5},
                {"slice_depth_mm", 50.0},
                {"slice_level_hu", 40.0},
                {"slice_window_hu", 400.0},
                {"slice_cuts", false},
                {"volume", "none"},
                {"volume_level_hu", 300.0},
                {"volume_window_hu", 600.0},
                {"picture", "camera"},
                {"free_yaw", 0.0},
                {"free_pitch", 0.0},
                {"free_zoom", 1.3},
                {"free_target_mm", {0.0, 0.0, 0.0}},
                {"free_colors", "live"},
                {"free_hole", false},
                {"free_bare_skin", false}};
  json status_ = {
      {"state", "waiting"},
      {"held", false},
      {"doubts", json::array()},
      {"bound_mm", 0.64},
      {"colors_age_ms", 40.0},
      {"starting", nullptr},
      {"search", nullptr},
      {"frozen", false},
      {"rms_distance_mm", 1.9},
      {"e_valid_mm", 1.6},
      {"explained_fraction", 0.87},
      {"frame_rate", 29.7},
      {"stage_ms", {{"camera", 2.0}, {"depth", 3.1}, {"registration", 4.2}, {"render", 12.0}}},
      {"frames", {{"tracked", 1204}, {"uncertain", 7}, {"lost", 1}, {"resumed", 1}}},
      {"method", "field"},
      {"camera", "simulated:"},
      {"camera_error", nullptr},
      {"calibration",
       {{"source", "found with a board"},
        {"made_at", "2026-11-14T15:00:00Z"},
        {"age", "12 days old"},
        {"depth_corrected", true},
        {"hint", nullptr}}}};
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Serves a moving test pattern");
  mor::LiveServerOptions options{.port = 0, .web_root = "web/dist"};
  std::string picture;
  double frames_per_s = 30.0;
  app.add_option("--port", options.port);
  app.add_option("--web-root", options.web_root);
  app.add_option("--max-viewers", options.max_viewers);
  app.add_option("--picture", picture, "A PNG instead of the colour waves");
  app.add_option("--fps", frames_per_s)->check(CLI::Range(1.0, 120.0));
  CLI11_PARSE(app, argc, argv);
  mor::log::set_up(false);
  std::signal(SIGINT, [](int) { stop_requested = true; });
  std::signal(SIGTERM, [](int) { stop_requested = true; });

  PretendedSession session;
  const auto server = mor::LiveServer::start(options, session.routes());
  if (!server) {
    std::cerr << server.error().message << '\n';
    return 1;
  }
  std::cout << "http://127.0.0.1:" << (*server)->port() << std::endl;

  std::optional<mor::testing::TestPattern> pattern;
  std::pair<int, int> size;
  const auto period =
      std::chrono::round<Clock::duration>(std::chrono::duration<double>(1.0 / frames_per_s));
  auto next_at = Clock::now();
  for (std::uint32_t frame_id = 1; !stop_requested; ++frame_id) {
    // A camera does not make up for pictures that it missed.
    next_at = std::max(next_at + period, Clock::now());
    std::this_thread::sleep_until(next_at);
    if (frame_id % 6 == 0) (*server)->publish_status(session.status((*server)->stats()));
    const auto wish = session.wish();
    if (wish.stands) continue;
    if (std::pair now{wish.width, wish.height}; !pattern || size != now) {
      size = now;
      pattern.emplace(size.first, size.second);
      if (!picture.empty()) {
        auto over = mor::testing::TestPattern::over_picture(picture, size.first, size.second);
        if (!over) {
          std::cerr << over.error().message << '\n';
          return 1;
        }
        pattern = *std::move(over);
      }
    }
    const auto captured_at = Clock::now();
    const auto view = pattern->draw(frame_id);
    if (frame_id % 10 == 1) session.remember(view);
    (*server)->show(view,
                    {captured_at, json{{"frame_id", frame_id}, {"state", wish.state}}.dump()});
  }
  return 0;
}
