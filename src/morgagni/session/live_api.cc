// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/live_api.h"

#include <charconv>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/image_png.h"
#include "morgagni/core/version.h"
#include "morgagni/render/skin_view.h"
#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

using Json = nlohmann::json;

constexpr int kMinViewSidePx = 16;
constexpr int kMaxViewSidePx = 2048;

tl::unexpected<Error> refuse(const std::string& sentence) {
  return make_error(ErrorCode::kInvalidArgument, sentence);
}

int http_status(ErrorCode code) {
  return code == ErrorCode::kInvalidArgument ? 400 : 500;
}

HttpResponse answer(const Result<Json>& result) {
  if (result) return {200, "application/json", result->dump()};
  return {http_status(result.error().code),
          "application/json",
          Json{{"error", result.error().message}}.dump()};
}

Result<Json> done(const Result<void>& result) {
  if (!result) return tl::unexpected<Error>(result.error());
  return Json::object();
}

Result<Json> parse_object(const std::string& text) {
  Json json = Json::parse(text.empty() ? "{}" : text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return refuse("the request must be a JSON object");
  return json;
}

Result<double> number(const Json& json,
                      const std::string& name,
                      std::optional<double> fallback = {}) {
  const auto found = json.find(name);
  if (found == json.end() && fallback) return *fallback;
  if (found == json.end() || !found->is_number())
    return refuse(fmt::format("{} must be a number", name));
  return found->get<double>();
}

Result<Eigen::Vector3d> point(const Json& json, const std::string& name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array() || found->size() != 3) {
    return refuse(fmt::format("{} must be three numbers", name));
  }
  Eigen::Vector3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(*found)[i].is_number()) return refuse(fmt::format("{} must be three numbers", name));
    result[static_cast<Eigen::Index>(i)] = (*found)[i].get<double>();
  }
  return result;
}

Json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Result<PlacementOptions> parse_placement(const std::string& body, PlacementOptions placement) {
  MOR_TRY(const Json json, parse_object(body));
  MOR_TRY(placement.distance_mm, number(json, "distance_mm", placement.distance_mm));
  MOR_TRY(placement.roll_rad, number(json, "roll_rad", placement.roll_rad));
  if (const auto side = json.find("side"); side != json.end()) {
    const auto parsed =
        side->is_string() ? parse_body_side(side->get<std::string>()) : std::nullopt;
    if (!parsed) {
      return refuse(
          fmt::format("side must be anterior, posterior, left or right, got {}", side->dump()));
    }
    placement.side = *parsed;
  }
  return placement;
}

Result<std::vector<LandmarkPair>> parse_pairs(const std::string& body) {
  MOR_TRY(const Json json, parse_object(body));
  const auto list = json.find("pairs");
  if (list == json.end() || !list->is_array()) return refuse("pairs must be a list");
  std::vector<LandmarkPair> pairs;
  for (const auto& item : *list) {
    MOR_TRY(const auto ct, point(item, "ct_mm"));
    MOR_TRY(const auto depth, point(item, "depth_mm"));
    pairs.push_back({ct, depth});
  }
  return pairs;
}

Result<int> side_px(double value, const std::string& name) {
  if (!(value >= kMinViewSidePx && value <= kMaxViewSidePx)) {
    return refuse(
        fmt::format("{} must be {} to {} px, got {}", name, kMinViewSidePx, kMaxViewSidePx, value));
  }
  return static_cast<int>(value);
}

Result<SkinViewpoint> parse_viewpoint(const Json& json) {
  SkinViewpoint viewpoint;
  MOR_TRY(viewpoint.yaw_rad, number(json, "yaw", viewpoint.yaw_rad));
  MOR_TRY(viewpoint.pitch_rad, number(json, "pitch", viewpoint.pitch_rad));
  MOR_TRY(viewpoint.zoom, number(json, "zoom", viewpoint.zoom));
  if (!(viewpoint.zoom >= 0.2 && viewpoint.zoom <= 20.0)) {
    return refuse(fmt::format("zoom must be 0.2 to 20, got {}", viewpoint.zoom));
  }
  MOR_TRY(const double width, number(json, "width", viewpoint.width_px));
  MOR_TRY(const double height, number(json, "height", viewpoint.height_px));
  MOR_TRY(viewpoint.width_px, side_px(width, "width"));
  MOR_TRY(viewpoint.height_px, side_px(height, "height"));
  return viewpoint;
}

/// The query's numbers as the JSON that the POST form of the same viewpoint has.
Result<Json> numbers(const std::map<std::string, std::string>& query) {
  Json json = Json::object();
  for (const auto& [name, text] : query) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
      return refuse(fmt::format("{} must be a number, got \"{}\"", name, text));
    }
    json[name] = value;
  }
  return json;
}

std::string hex_color(const Eigen::Vector3f& color) {
  const auto byte = [](float share) { return std::lround(std::clamp(share, 0.0F, 1.0F) * 255.0F); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(color.x()), byte(color.y()), byte(color.z()));
}

Json case_json(const Case& body, const PlacementOptions& placement) {
  Json structures = Json::array();
  for (const auto& structure : scene_of(body).structures) {
    structures.push_back({{"name", structure.name}, {"color", hex_color(structure.color)}});
  }
  Json windows = Json::object();
  for (const VolumePreset preset : kVolumePresets) {
    const auto [level_hu, window_hu] = volume_window(preset);
    windows[std::string(to_string(preset))] = {{"level_hu", level_hu}, {"window_hu", window_hu}};
  }
  return {{"name", body.name},
          {"description", body.ct_description},
          {"structures", structures},
          {"has_ct", body.volume != nullptr},
          {"volume_presets", windows},
          {"start_options",
           {{"distance_mm", placement.distance_mm},
            {"min", PlacementOptions::kMinDistanceMm},
            {"max", PlacementOptions::kMaxDistanceMm}}},
          {"version", kVersion}};
}

HttpResponse png(const std::vector<std::byte>& bytes) {
  return {200, "image/png", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())};
}

Result<Json> pick_on_skin(const Case& body, const std::string& text) {
  MOR_TRY(const Json json, parse_object(text));
  MOR_TRY(const auto viewpoint, parse_viewpoint(json));
  MOR_TRY(const double x, number(json, "x"));
  MOR_TRY(const double y, number(json, "y"));
  const auto ct = draw_skin_view(body.skin->mesh, viewpoint).ct_point({x, y});
  if (!ct) return refuse("there is no skin at this point: tap the body");
  return Json{{"ct_mm", to_json(*ct)}};
}

Result<Json> pick_on_live(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json json, parse_object(text));
  MOR_TRY(const double x, number(json, "x"));
  MOR_TRY(const double y, number(json, "y"));
  MOR_TRY(const auto depth, loop.pick_landmark({x, y}));
  return Json{{"depth_mm", to_json(depth)}};
}

Result<Json> solve(const std::string& text) {
  MOR_TRY(const auto pairs, parse_pairs(text));
  MOR_TRY(const auto start, start_from_landmarks(pairs));
  return Json{{"fre_mm", start.fre_mm}, {"residuals_mm", start.residuals_mm}};
}

Result<Json> accept(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const auto pairs, parse_pairs(text));
  return done(loop.accept_landmarks(pairs));
}

Result<Json> start_placement(LiveLoop& loop,
                             const PlacementOptions& base,
                             const std::string& text) {
  MOR_TRY(const auto placement, parse_placement(text, base));
  return done(loop.start_by_placement(placement));
}

Result<Json> touch(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json json, parse_object(text));
  MOR_TRY(const double x, number(json, "x"));
  MOR_TRY(const double y, number(json, "y"));
  MOR_TRY(const auto touched, loop.touch({x, y}));
  return Json{{"ct_mm", to_json(touched.ct_mm)},
              {"bound_mm", or_null(touched.bound_mm)},
              {"state", to_string(touched.state)}};
}

Result<Json> change_view(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const auto view, changed(loop.view(), text));
  loop.set_view(view);
  return Json::parse(to_json(view));
}

Result<Json> freeze(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json json, parse_object(text));
  if (!json.contains("frozen") || !json["frozen"].is_boolean())
    return refuse("frozen must be true or false");
  loop.set_frozen(json["frozen"].get<bool>());
  return Json::object();
}

HttpResponse skin_view(const Case& body, const HttpRequest& request) {
  const auto query = numbers(request.query);
  if (!query) return answer(tl::unexpected<Error>(query.error()));
  const auto viewpoint = parse_viewpoint(*query);
  if (!viewpoint) return answer(tl::unexpected<Error>(viewpoint.error()));
  return png(encode_png(draw_skin_view(body.skin->mesh, *viewpoint).picture.view()));
}

HttpResponse snapshot(const LiveLoop& loop) {
  const auto picture = loop.snapshot();
  if (picture.empty()) return answer(refuse("there is no picture yet"));
  return png(encode_png(picture.view()));
}

}  // namespace

std::vector<HttpRoute> make_live_routes(std::shared_ptr<const Case> body,
                                        std::shared_ptr<LiveLoop> loop,
                                        const PlacementOptions& placement) {
  const auto post = [](std::string path, std::function<Result<Json>(const std::string&)> act) {
    return HttpRoute{"POST", std::move(path), [act = std::move(act)](const HttpRequest& request) {
                       return answer(act(request.body));
                     }};
  };
  return {
      {"GET", "/api/case", [=](const HttpRequest&) { return answer(case_json(*body, placement)); }},
      {"GET", "/api/skin-view.png", [=](const HttpRequest& r) { return skin_view(*body, r); }},
      {"GET", "/api/snapshot.png", [=](const HttpRequest&) { return snapshot(*loop); }},
      post("/api/view", [=](const auto& text) { return change_view(*loop, text); }),
      post("/api/freeze", [=](const auto& text) { return freeze(*loop, text); }),
      post("/api/touch", [=](const auto& text) { return touch(*loop, text); }),
      post("/api/start/automatic",
           [=](const auto&) -> Result<Json> {
             loop->start_automatically();
             return Json::object();
           }),
      post("/api/start/placement",
           [=](const auto& text) { return start_placement(*loop, placement, text); }),
      post("/api/landmarks/begin", [=](const auto&) { return done(loop->begin_landmarks()); }),
      post("/api/landmarks/ct", [=](const auto& text) { return pick_on_skin(*body, text); }),
      post("/api/landmarks/live", [=](const auto& text) { return pick_on_live(*loop, text); }),
      post("/api/landmarks/solve", [](const auto& text) { return solve(text); }),
      post("/api/landmarks/accept", [=](const auto& text) { return accept(*loop, text); }),
      post("/api/landmarks/cancel", [=](const auto&) -> Result<Json> {
        loop->cancel_landmarks();
        return Json::object();
      })};
}

namespace {

/// What the page says while it waits for a start.
Json search_json(const SearchStatus& search) {
  if (!search.is_searching && !search.last) return nullptr;
  Json json = {{"searching", search.is_searching}, {"last", nullptr}, {"reason", search.reason}};
  if (search.last) json["last"] = to_string(*search.last);
  return json;
}

std::string_view starting(const LiveStatus& status) {
  if (status.picking_landmarks) return "landmarks";
  return status.last.ct_from_ghost ? "placement" : "automatic";
}

}  // namespace

std::string status_json(const LiveStatus& status,
                        const ViewSettings& view,
                        const LiveServerStats& stream,
                        std::string_view method,
                        std::string_view camera) {
  const auto& last = status.last;
  const auto& registration = last.registration;
  Json json = {
      {"state", to_string(last.state)},
      {"held", last.is_held},
      {"doubts", Json::array()},
      {"bound_mm", or_null(status.bound_mm)},
      {"starting", nullptr},
      {"search", search_json(status.search)},
      {"frozen", status.frozen},
      {"rms_distance_mm", nullptr},
      {"e_valid_mm", nullptr},
      {"explained_fraction", nullptr},
      {"frame_rate", status.frame_rate},
      {"latency_ms",
       {{"median", stream.capture_to_encoded_ms}, {"p95", stream.capture_to_encoded_p95_ms}}},
      {"stage_ms",
       {{"camera", status.wait_ms},
        {"depth", status.depth_ms},
        {"registration", status.registration_ms},
        {"judgement", status.judgement_ms},
        {"render", status.render_ms},
        {"encode", stream.encode_ms}}},
      {"frames",
       {{"tracked", last.counts.tracked},
        {"uncertain", last.counts.uncertain},
        {"lost", last.counts.lost},
        {"resumed", last.counts.resumed},
        {"dropped", status.num_dropped + stream.num_dropped}}},
      {"method", method},
      {"camera", camera},
      {"camera_error", nullptr},
      {"viewers", stream.num_viewers},
      {"view", Json::parse(to_json(view))}};
  const bool has_start = last.state != TrackingState::kWaiting;
  if (status.picking_landmarks || !has_start) json["starting"] = starting(status);
  for (const auto doubt : last.doubts) json["doubts"].push_back(to_string(doubt));
  if (registration && registration->num_pairs > 0) {
    json["rms_distance_mm"] = registration->rms_distance_mm;
    json["explained_fraction"] = registration->explained_fraction;
  }
  if (last.valid_rms_mm) json["e_valid_mm"] = *last.valid_rms_mm;
  if (status.camera_error) json["camera_error"] = *status.camera_error;
  return json.dump();
}

}  // namespace mor
