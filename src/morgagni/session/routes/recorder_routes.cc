// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/recorder_routes.h"

#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;

std::string_view name_of(RecorderState state) {
  switch (state) {
    case RecorderState::kIdle:
      return "idle";
    case RecorderState::kRecording:
      return "recording";
    case RecorderState::kFinishing:
      return "finishing";
  }
  return "";
}

Json to_json(const RecorderStatus& status) {
  return {{"state", name_of(status.state)},
          {"seconds", status.video.seconds},
          {"bytes", status.video.num_bytes},
          {"pictures", status.video.num_pictures},
          {"name", status.name},
          {"said", status.last_said},
          {"failed", status.last_failed}};
}

}  // namespace

std::vector<HttpRoute> make_recorder_routes(std::shared_ptr<Recorder> recorder) {
  return {api::get("/api/video",
                   [=](const HttpRequest&) { return api::answer(to_json(recorder->status())); }),
          api::post("/api/video/start",
                    [=](const auto&) -> Result<Json> {
                      MOR_CHECK(recorder->start());
                      return to_json(recorder->status());
                    }),
          api::post("/api/video/stop", [=](const auto&) -> Result<Json> {
            MOR_CHECK(recorder->stop());
            return to_json(recorder->status());
          })};
}

}  // namespace mor
