// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/still_routes.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/utc.h"
#include "morgagni/core/version.h"
#include "morgagni/render/pick.h"
#include "morgagni/session/evidence_json.h"
#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using api::Json;
using api::refuse;

constexpr std::uintmax_t kMaxPictureBytes = 256U << 20U;

std::vector<Eigen::Vector2d> places_of(const Json& list, bool& is_dim) {
  std::vector<Eigen::Vector2d> places;
  for (const auto& item : list) {
    places.emplace_back(item[0].get<double>(), item[1].get<double>());
    is_dim = is_dim && item[2].get<int>() != 0;
  }
  return places;
}

std::vector<StillMark> marks_of(const std::string& text) {
  std::vector<StillMark> marks;
  const Json list = Json::parse(text.empty() ? "[]" : text, nullptr, /*allow_exceptions=*/false);
  for (const auto& item : list) {
    if (item["kind"] == "pick") continue;
    StillMark mark{.id = item["id"], .label = item["label"], .points_px = {}, .line_px = {}};
    mark.is_dim = true;
    mark.points_px = places_of(item["points"], mark.is_dim);
    mark.line_px = places_of(item["line"], mark.is_dim);
    marks.push_back(std::move(mark));
  }
  return marks;
}

/// z of the skin in the middle of the hole.
std::optional<double> skin_depth_mm(const Case& body, const ShownPicture& shown) {
  const RenderScene scene{.structures = {}, .skin = body.skin->mesh};
  OverlayView view{.color_camera = shown.camera, .color_from_ct = shown.camera_from_ct};
  view.hole = {.center = shown.view.hole.center, .radius = 0.0F};
  const Eigen::Vector2d middle(view.hole.center.x() * shown.camera.width_px - 0.5,
                               view.hole.center.y() * shown.camera.height_px - 0.5);
  const auto picked = pick_point(scene, view, middle);
  if (!picked) return std::nullopt;
  return (*shown.camera_from_ct * picked->ct_mm).z();
}

std::string state_words(const TrackedFrame& tracked) {
  std::string words(to_string(tracked.state));
  if (tracked.is_held) words += " (pose of an earlier picture)";
  return words;
}

evidence::Json evidence_of(const Case& body, const Snapshot& snapshot, const StillWords& words) {
  const auto& shown = snapshot.shown;
  evidence::Json json = evidence::head(body);
  json["taken_at"] = words.taken_at;
  json["frame_id"] = shown.tracked.frame->frame_id;
  json["state"] = to_string(shown.tracked.state);
  json["held"] = shown.tracked.is_held;
  json["bound_mm"] = shown.bound_mm ? evidence::Json(*shown.bound_mm) : evidence::Json(nullptr);
  json["camera"] = evidence::to_json(shown.camera);
  json["ct_from_camera"] = nullptr;
  if (shown.camera_from_ct)
    json["ct_from_camera"] = evidence::to_json(shown.camera_from_ct->inverse());
  json["calibration"] = evidence::to_json(*shown.tracked.frame->calibration);
  json["registered_to"] = evidence::skin_words(shown.tracked.fixed);
  json["view"] = evidence::Json::parse(to_json(shown.view));
  json["scale_depth_mm"] =
      words.scale_depth_mm ? evidence::Json(*words.scale_depth_mm) : evidence::Json(nullptr);
  return json;
}

Result<Json> take_still(const Case& body, const LiveLoop& loop, const std::string& text) {
  MOR_TRY(const Json request, api::parse_object(text));
  const auto asked = request.find("style");
  const auto style = asked != request.end() && asked->is_string()
                         ? parse_still_style(asked->get<std::string>())
                         : std::nullopt;
  if (!style) return refuse("style must be plain, burned-in or beside");
  const auto snapshot = loop.snapshot();
  if (!snapshot) return refuse("there is no picture yet");
  const StillWords words = still_words(body, snapshot->shown, snapshot->marks);
  MOR_TRY(const auto still, draw_still(snapshot->pixels.view(), words, *style));
  const auto png = encode_png(still.view());

  const fs::path folder = body.folder / "pictures";
  std::error_code status;
  fs::create_directories(folder, status);
  if (status) {
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: cannot be made: {}", folder.string(), status.message()));
  }
  const std::string time = evidence::file_name(std::chrono::system_clock::now());
  std::string name = time;
  for (int i = 2; fs::exists(folder / (name + ".png")); ++i) name = fmt::format("{}-{}", time, i);
  evidence::Json json = evidence_of(body, *snapshot, words);
  json["kind"] = "still";
  json["style"] = to_string(*style);
  json["sha256"] = {{name + ".png", sha256_hex(png)}};
  MOR_CHECK(write_file(folder / (name + ".png"), png));
  MOR_CHECK(write_file(folder / (name + ".json"), json.dump(2) + "\n"));
  return Json{{"name", name + ".png"}, {"width", still.width()}, {"height", still.height()}};
}

/// A name as take_still() gives it, nothing that leads elsewhere.
bool is_still_name(const std::string& name) {
  return name.ends_with(".png") && name.size() < 60 &&
         std::all_of(name.begin(), name.end() - 4, [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-';
         });
}

HttpResponse still_png(const Case& body, const HttpRequest& request) {
  const auto name = request.query.find("name");
  if (name == request.query.end() || !is_still_name(name->second))
    return api::answer(refuse("name must be that of a still"));
  const auto bytes = read_file(body.folder / "pictures" / name->second, kMaxPictureBytes);
  if (!bytes) return api::answer(refuse("there is no such still"));
  return {
      200, "image/png", std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())};
}

}  // namespace

StillWords still_words(const Case& body, const ShownPicture& shown, const std::string& marks) {
  const auto& tracked = shown.tracked;
  StillWords words{
      .case_name = body.name,
      .taken_at = utc_text(evidence::wall_clock(tracked.frame->captured_at)),
      .state = state_words(tracked),
      .bound_mm = shown.bound_mm,
      .made_by = fmt::format("Morgagni {}, frame {}", kVersion, tracked.frame->frame_id),
      .camera = shown.camera,
      .camera_from_ct = shown.camera_from_ct,
      .scale_depth_mm = std::nullopt,
      .scale_place = "on the skin in the middle of the hole",
      .marks = marks_of(marks)};
  if (!shown.camera_from_ct) return words;
  words.scale_depth_mm = skin_depth_mm(body, shown);
  if (words.scale_depth_mm) return words;
  words.scale_place = "in the middle of the body";
  const Eigen::Vector3d middle = body.skin->mesh.bounds().center().cast<double>();
  const double depth_mm = (*shown.camera_from_ct * middle).z();
  if (depth_mm > 1.0) words.scale_depth_mm = depth_mm;
  return words;
}

std::vector<HttpRoute> make_still_routes(std::shared_ptr<const Case> body,
                                         std::shared_ptr<const LiveLoop> loop) {
  return {api::post("/api/still", [=](const auto& text) { return take_still(*body, *loop, text); }),
          api::get("/api/still.png",
                   [=](const HttpRequest& request) { return still_png(*body, request); })};
}

}  // namespace mor
