// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/recording_routes.h"

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/version.h"
#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;

Result<ColorCoding> color_coding(const Json& json) {
  const auto color = json.find("color");
  if (color == json.end() || *color == "jpeg") return ColorCoding::kJpeg;
  if (*color == "lossless") return ColorCoding::kLossless;
  return api::refuse(fmt::format("color must be jpeg or lossless, got {}", color->dump()));
}

Json to_json(const SessionRecorder::State& state) {
  const auto& progress = state.progress;
  return {{"recording", state.is_recording},
          {"file", state.file.empty() ? Json() : Json(state.file)},
          {"seconds", std::chrono::duration<double>(progress.duration).count()},
          {"frames", progress.num_frames},
          {"dropped", progress.num_dropped},
          {"bytes", progress.num_bytes},
          {"error", progress.error ? Json(progress.error->message) : Json()}};
}

Result<Json> start(SessionRecorder& recorder, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text.empty() ? "{}" : text));
  MOR_TRY(const auto color, color_coding(json));
  MOR_TRY(const auto state, recorder.start(color));
  return to_json(state);
}

Result<Json> stop(SessionRecorder& recorder) {
  MOR_TRY(const auto state, recorder.stop());
  return to_json(state);
}

}  // namespace

std::shared_ptr<SessionRecorder> make_session_recorder(const Case& body,
                                                       const std::string& camera_name) {
  return std::make_shared<SessionRecorder>(
      body.folder / "recordings",
      std::vector<std::pair<std::string, std::string>>{
          {"case", body.name}, {"camera", camera_name}, {"morgagni", kVersion}});
}

std::vector<HttpRoute> make_recording_routes(std::shared_ptr<SessionRecorder> recorder) {
  return {api::get("/api/recording",
                   [=](const HttpRequest&) { return api::answer(to_json(recorder->state())); }),
          api::post("/api/recording/start",
                    [=](const std::string& text) { return start(*recorder, text); }),
          api::post("/api/recording/stop", [=](const std::string&) { return stop(*recorder); })};
}

}  // namespace mor
