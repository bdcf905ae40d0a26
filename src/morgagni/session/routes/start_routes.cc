// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/start_routes.h"

#include <optional>

#include <spdlog/fmt/fmt.h>

#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;
using api::number;
using api::point;
using api::refuse;

Result<PlacementOptions> parse_placement(const std::string& body, PlacementOptions placement) {
  MOR_TRY(const Json json, api::parse_object(body));
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
  MOR_TRY(const Json json, api::parse_object(body));
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

Result<Json> pick_on_live(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text));
  MOR_TRY(const double x, number(json, "x"));
  MOR_TRY(const double y, number(json, "y"));
  MOR_TRY(const auto depth, loop.pick_landmark({x, y}));
  return Json{{"depth_mm", api::to_json(depth)}};
}

Result<Json> solve(const std::string& text) {
  MOR_TRY(const auto pairs, parse_pairs(text));
  MOR_TRY(const auto start, start_from_landmarks(pairs));
  return Json{{"fre_mm", start.fre_mm}, {"residuals_mm", start.residuals_mm}};
}

Result<Json> accept(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const auto pairs, parse_pairs(text));
  return api::done(loop.accept_landmarks(pairs));
}

Result<Json> start_placement(LiveLoop& loop,
                             const PlacementOptions& base,
                             const std::string& text) {
  MOR_TRY(const auto placement, parse_placement(text, base));
  return api::done(loop.start_by_placement(placement));
}

}  // namespace

std::vector<HttpRoute> make_start_routes(std::shared_ptr<LiveLoop> loop,
                                         const PlacementOptions& placement) {
  using api::done;
  using api::post;
  return {post("/api/start/automatic",
               [=](const auto&) -> Result<Json> {
                 loop->start_automatically();
                 return Json::object();
               }),
          post("/api/start/placement",
               [=](const auto& text) { return start_placement(*loop, placement, text); }),
          post("/api/landmarks/begin", [=](const auto&) { return done(loop->begin_landmarks()); }),
          post("/api/landmarks/live", [=](const auto& text) { return pick_on_live(*loop, text); }),
          post("/api/landmarks/solve", [](const auto& text) { return solve(text); }),
          post("/api/landmarks/accept", [=](const auto& text) { return accept(*loop, text); }),
          post("/api/landmarks/cancel", [=](const auto&) -> Result<Json> {
            loop->cancel_landmarks();
            return Json::object();
          })};
}

}  // namespace mor
