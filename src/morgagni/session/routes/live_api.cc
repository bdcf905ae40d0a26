// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/live_api.h"

#include "morgagni/core/printable_text.h"
#include "morgagni/core/utc.h"
#include "morgagni/session/routes/api_json.h"
#include "morgagni/session/routes/case_routes.h"
#include "morgagni/session/routes/start_routes.h"
#include "morgagni/session/routes/view_routes.h"

namespace mor {

std::vector<HttpRoute> make_live_routes(std::shared_ptr<const Case> body,
                                        std::shared_ptr<LiveLoop> loop,
                                        const PlacementOptions& placement) {
  return api::joined({make_case_routes(std::move(body), placement),
                      make_start_routes(loop, placement),
                      make_view_routes(loop)});
}

namespace {

using api::Json;

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

Json calibration_json(const CalibrationOrigin& origin) {
  const auto or_null = [](const std::string& text) {
    return text.empty() ? Json(nullptr) : Json(text);
  };
  return {{"source", printable_text(origin.source)},
          {"made_at", origin.made_at ? Json(utc_text(*origin.made_at)) : Json(nullptr)},
          {"age", or_null(origin.age)},
          {"depth_corrected", origin.is_depth_corrected},
          {"hint", or_null(printable_text(origin.hint))}};
}

}  // namespace

std::string status_json(const LiveStatus& status,
                        const ViewSettings& view,
                        const LiveServerStats& stream,
                        std::string_view method,
                        std::string_view camera,
                        const CalibrationOrigin& calibration) {
  const auto& last = status.last;
  const auto& registration = last.registration;
  Json json = {
      {"state", to_string(last.state)},
      {"held", last.is_held},
      {"doubts", Json::array()},
      {"bound_mm", api::or_null(status.bound_mm)},
      {"colors_age_ms", api::or_null(status.colors_age_ms)},
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
      {"calibration", calibration_json(calibration)},
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
