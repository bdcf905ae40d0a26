// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/case_routes.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/version.h"
#include "morgagni/render/skin_view.h"
#include "morgagni/session/routes/api_json.h"
#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

using api::Json;
using api::number;
using api::refuse;

constexpr int kMinViewSidePx = 16;
constexpr int kMaxViewSidePx = 2048;

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
          {"skin_radius_mm", bounding_sphere(body.skin->mesh).radius_mm},
          {"start_options",
           {{"distance_mm", placement.distance_mm},
            {"min", PlacementOptions::kMinDistanceMm},
            {"max", PlacementOptions::kMaxDistanceMm}}},
          {"version", kVersion}};
}

Result<Json> pick_on_skin(const Case& body, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text));
  MOR_TRY(const auto viewpoint, parse_viewpoint(json));
  MOR_TRY(const double x, number(json, "x"));
  MOR_TRY(const double y, number(json, "y"));
  const auto ct = draw_skin_view(body.skin->mesh, viewpoint).ct_point({x, y});
  if (!ct) return refuse("there is no skin at this point: tap the body");
  return Json{{"ct_mm", api::to_json(*ct)}};
}

HttpResponse skin_view(const Case& body, const HttpRequest& request) {
  const auto viewpoint = api::numbers(request.query).and_then(parse_viewpoint);
  if (!viewpoint) return api::answer(tl::unexpected<Error>(viewpoint.error()));
  const SkinView view = draw_skin_view(body.skin->mesh, *viewpoint);
  return api::png_answer(view.picture.view());
}

}  // namespace

std::vector<HttpRoute> make_case_routes(std::shared_ptr<const Case> body,
                                        const PlacementOptions& placement) {
  return {
      api::get("/api/case",
               [=](const HttpRequest&) { return api::answer(case_json(*body, placement)); }),
      api::get("/api/skin-view.png", [=](const HttpRequest& r) { return skin_view(*body, r); }),
      api::post("/api/landmarks/ct", [=](const auto& text) { return pick_on_skin(*body, text); })};
}

}  // namespace mor
