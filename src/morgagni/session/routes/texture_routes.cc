// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/texture_routes.h"

#include <string>

#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;
using api::refuse;

Json to_json(const TextureStatus& status) {
  return {{"ready", status.is_ready},
          {"recording", status.is_recording},
          {"coverage", status.coverage},
          {"frames", status.num_frames},
          {"last", status.last ? Json(to_string(*status.last)) : Json(nullptr)},
          {"version", status.version},
          {"saving", status.is_saving},
          {"saved", status.is_saved},
          {"problem", status.problem.empty() ? Json(nullptr) : Json(status.problem)}};
}

Result<Json> record(TextureRecorder& recorder, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text));
  MOR_TRY(const bool on, api::truth(json, "recording"));
  return api::done(recorder.record(on));
}

HttpResponse sides(const TextureRecorder& recorder) {
  const auto png = recorder.sides_png();
  if (png.empty()) return api::answer(refuse("the skin is being unwrapped: try again in a moment"));
  return {200, "image/png", std::string(reinterpret_cast<const char*>(png.data()), png.size())};
}

HttpResponse color(const TextureRecorder& recorder) {
  const auto texture = recorder.texture();
  if (!texture) return api::answer(refuse("the skin is being unwrapped: try again in a moment"));
  return api::png_answer(texture->color.view());
}

}  // namespace

std::vector<HttpRoute> make_texture_routes(std::shared_ptr<TextureRecorder> recorder) {
  return {
      api::get("/api/texture",
               [=](const HttpRequest&) { return api::answer(to_json(recorder->status())); }),
      api::get("/api/texture/sides.png", [=](const HttpRequest&) { return sides(*recorder); }),
      api::get("/api/texture/color.png", [=](const HttpRequest&) { return color(*recorder); }),
      api::post("/api/texture/record", [=](const auto& text) { return record(*recorder, text); }),
      api::post("/api/texture/clear",
                [=](const auto&) -> Result<Json> {
                  recorder->start_again();
                  return Json::object();
                }),
      api::post("/api/texture/save", [=](const auto&) { return api::done(recorder->save()); })};
}

}  // namespace mor
