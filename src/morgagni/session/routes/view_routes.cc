// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/view_routes.h"

#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;
using api::number;

Result<Json> touch(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text));
  MOR_TRY(const double x, number(json, "x"));
  MOR_TRY(const double y, number(json, "y"));
  MOR_TRY(const auto touched, loop.touch({x, y}));
  return Json{{"ct_mm", api::to_json(touched.ct_mm)},
              {"bound_mm", api::or_null(touched.bound_mm)},
              {"state", to_string(touched.state)}};
}

Result<Json> change_view(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const auto view, changed(loop.view(), text));
  loop.set_view(view);
  return Json::parse(to_json(view));
}

Result<Json> freeze(LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text));
  MOR_TRY(const bool frozen, api::truth(json, "frozen"));
  loop.set_frozen(frozen);
  return Json::object();
}

HttpResponse snapshot_png(const LiveLoop& loop) {
  const auto snapshot = loop.snapshot();
  if (!snapshot) return api::answer(api::refuse("there is no picture yet"));
  return api::png_answer(snapshot->pixels.view());
}

}  // namespace

std::vector<HttpRoute> make_view_routes(std::shared_ptr<LiveLoop> loop) {
  return {api::get("/api/snapshot.png", [=](const HttpRequest&) { return snapshot_png(*loop); }),
          api::post("/api/view", [=](const auto& text) { return change_view(*loop, text); }),
          api::post("/api/freeze", [=](const auto& text) { return freeze(*loop, text); }),
          api::post("/api/touch", [=](const auto& text) { return touch(*loop, text); })};
}

}  // namespace mor
