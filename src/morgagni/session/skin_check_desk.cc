// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/skin_check_desk.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

using api::Json;
using api::refuse;

constexpr std::array<std::pair<const char*, BodyPlane>, 3> kPlanes = {
    {{"axial", BodyPlane::kAxial},
     {"coronal", BodyPlane::kCoronal},
     {"sagittal", BodyPlane::kSagittal}}};

std::string text_of(const HttpRequest& request, const char* name) {
  const auto found = request.query.find(name);
  return found == request.query.end() ? std::string() : found->second;
}

Result<double> number_of(const HttpRequest& request, const char* name, double low, double high) {
  const std::string text = text_of(request, name);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= low && value <= high)
    return value;
  return refuse(fmt::format("{} must be {} to {}, got \"{}\"", name, low, high, text));
}

std::string hex_color(Rgb8 color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color.r, color.g, color.b);
}

template <class T>
void append(std::string& bytes, const T* values, std::size_t num) {
  if (num > 0) bytes.append(reinterpret_cast<const char*>(values), num * sizeof(T));
}

std::string bytes_of(const TriangleMesh& mesh) {
  const std::array<std::uint32_t, 2> counts = {static_cast<std::uint32_t>(mesh.vertices.size()),
                                               static_cast<std::uint32_t>(mesh.triangles.size())};
  std::string bytes;
  append(bytes, counts.data(), counts.size());
  append(bytes, mesh.vertices.data(), mesh.vertices.size());
  append(bytes, mesh.triangles.data(), mesh.triangles.size());
  return bytes;
}

}  // namespace

SkinCheckDesk::SkinCheckDesk(std::shared_ptr<const Volume> volume,
                             UseBody use,
                             const SkinCheckOptions& options)
    : options_(options),
      use_(std::move(use)),
      check_(std::move(volume)),
      prepare_(options.prepare) {}

Result<void> SkinCheckDesk::begin() {
  return find(prepare_.skin);
}

Result<void> SkinCheckDesk::find(const SkinOptions& skin) {
  const auto started = std::chrono::steady_clock::now();
  MOR_CHECK(check_.find(skin));
  took_ = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() -
                                                                started);
  prepare_.skin = skin;
  ++version_;
  return {};
}

Json SkinCheckDesk::parts_json() const {
  Json parts = Json::array();
  for (const auto& part : check_.parts()) {
    const Eigen::Vector3d& middle = part.what.marks_mm[part.what.marks_mm.size() / 2];
    parts.push_back({{"place", part.what.place},
                     {"volume_ml", part.what.volume_ml},
                     {"size_mm", api::to_json(part.what.size_mm)},
                     {"stands_out", part.stands_out},
                     {"kept", part.is_kept},
                     {"color", hex_color(part.color)},
                     {"at", slices_through(middle)}});
  }
  return parts;
}

Json SkinCheckDesk::slices_through(const Eigen::Vector3d& place_mm) const {
  Json at = Json::object();
  for (const auto& [name, plane] : kPlanes) at[name] = check_.position(plane, place_mm);
  return at;
}

Json SkinCheckDesk::doubts_json() const {
  constexpr std::array<const char*, 4> kWhy = {
      "cover_taken", "layer_taken", "taken_off", "layer_left"};
  Json doubts = Json::array();
  for (const auto& doubt : check_.doubts())
    doubts.push_back({{"place", doubt.place},
                      {"area_cm2", doubt.area_cm2},
                      {"up_to_mm", doubt.up_to_mm},
                      {"why", kWhy[static_cast<std::size_t>(doubt.why)]},
                      {"at", slices_through(doubt.middle_mm)}});
  return doubts;
}

Json SkinCheckDesk::state() {
  constexpr std::array<const char*, 5> kStages = {
      "checking", "preparing", "done", "failed", "cancelled"};
  Json planes = Json::object();
  for (const auto& [name, plane] : kPlanes) planes[name] = api::to_json(check_.size_mm(plane));
  Json json = {{"title", options_.title},
               {"threshold_hu", prepare_.skin.threshold_hu},
               {"closing_mm", prepare_.skin.closing_mm},
               {"body_ml", check_.body_ml()},
               {"parts", parts_json()},
               {"doubts", doubts_json()},
               {"planes_mm", std::move(planes)},
               {"version", version_},
               {"took_ms", took_.count()}};
  const std::scoped_lock lock(mutex_);
  json["state"] = kStages[static_cast<std::size_t>(stage_)];
  json["step"] = step_;
  json["fraction"] = fraction_;
  json["error"] = error_.empty() ? Json(nullptr) : Json(error_);
  if (stage_ == Stage::kDone || stage_ == Stage::kCancelled) {
    end_was_told_ = true;
    changed_.notify_all();
  }
  return json;
}

Result<void> SkinCheckDesk::check_open() const {
  const std::scoped_lock lock(mutex_);
  if (stage_ == Stage::kChecking || stage_ == Stage::kFailed) return {};
  return refuse("the case is being made, or was cancelled: nothing can be changed any more");
}

/// What `key` names of a list of so many, as long as the list is the one that was shown.
Result<std::size_t> SkinCheckDesk::listed(const Json& json,
                                          const char* key,
                                          std::size_t size) const {
  MOR_TRY(const double number, api::number(json, key));
  MOR_TRY(const double version, api::number(json, "version"));
  if (version != version_) return refuse("the parts have changed meanwhile: look again");
  if (!(number >= 0.0 && number < static_cast<double>(size)) || number != std::floor(number))
    return refuse(fmt::format("there is no {} {}", key, number));
  return static_cast<std::size_t>(number);
}

/// One part kept or cut: its marks go into the options, or out of them.
Result<void> SkinCheckDesk::decide(SkinOptions& skin, const Json& json) const {
  MOR_TRY(const std::size_t index, listed(json, "part", check_.parts().size()));
  MOR_TRY(const bool keep, api::truth(json, "keep"));
  const BodyPart& part = check_.parts()[index];
  auto& marks = part.stands_out ? skin.cut_mm : skin.keep_mm;
  std::erase_if(marks, [&](const Eigen::Vector3d& mark) { return check_.holds(index, mark); });
  if (keep != part.stands_out)
    marks.insert(marks.end(), part.what.marks_mm.begin(), part.what.marks_mm.end());
  return {};
}

/// One layer that is left taken off, or one that was taken off so put back.
Result<void> SkinCheckDesk::take_off(SkinOptions& skin, const Json& json) const {
  MOR_TRY(const std::size_t index, listed(json, "doubt", check_.doubts().size()));
  MOR_TRY(const bool off, api::truth(json, "take_off"));
  const SkinDoubt& doubt = check_.doubts()[index];
  if (doubt.why != (off ? SkinDoubt::Why::kLayerLeft : SkinDoubt::Why::kTakenOff))
    return refuse(off ? "only a layer that may go on unseen can be taken off"
                      : "only a layer that was taken off on demand can be put back");
  auto& marks = skin.take_off_mm;
  if (off) {
    marks.push_back(doubt.middle_mm);
  } else if (!marks.empty()) {
    marks.erase(std::min_element(
        marks.begin(), marks.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
          return (a - doubt.middle_mm).norm() < (b - doubt.middle_mm).norm();
        }));
  }
  return {};
}

Result<Json> SkinCheckDesk::change(const std::string& text) {
  MOR_CHECK(check_open());
  MOR_TRY(const Json json, api::parse_object(text));
  SkinOptions skin = prepare_.skin;
  MOR_TRY(skin.threshold_hu, api::number(json, "threshold_hu", skin.threshold_hu));
  MOR_TRY(skin.closing_mm, api::number(json, "closing_mm", skin.closing_mm));
  if (json.contains("part")) MOR_CHECK(decide(skin, json));
  if (json.contains("doubt")) MOR_CHECK(take_off(skin, json));
  MOR_CHECK(find(skin));
  return state();
}

Result<Json> SkinCheckDesk::use() {
  MOR_CHECK(check_open());
  {
    const std::scoped_lock lock(mutex_);
    stage_ = Stage::kPreparing;
    step_ = "begin";
    fraction_ = 0.0;
    error_.clear();
  }
  worker_ = std::jthread([this, prepare = prepare_] {
    finish(use_(prepare, [this](std::string_view step, double fraction) {
      const std::scoped_lock lock(mutex_);
      step_ = step;
      fraction_ = fraction;
    }));
  });
  return state();
}

void SkinCheckDesk::finish(Result<PrepareSummary> made) {
  const std::scoped_lock lock(mutex_);
  stage_ = made ? Stage::kDone : Stage::kFailed;
  if (made) {
    made_ = *std::move(made);
  } else {
    error_ = made.error().message;
  }
  changed_.notify_all();
}

Result<Json> SkinCheckDesk::cancel() {
  MOR_CHECK(check_open());
  {
    const std::scoped_lock lock(mutex_);
    stage_ = Stage::kCancelled;
  }
  return state();
}

HttpResponse SkinCheckDesk::slice(const HttpRequest& request) const {
  const std::string wanted = text_of(request, "plane");
  const auto plane = std::find_if(
      kPlanes.begin(), kPlanes.end(), [&](const auto& known) { return wanted == known.first; });
  if (plane == kPlanes.end())
    return api::answer(
        refuse(fmt::format("plane must be axial, coronal or sagittal, got \"{}\"", wanted)));
  const auto position = number_of(request, "position", 0.0, 1.0);
  if (!position) return api::answer(tl::unexpected<Error>(position.error()));
  const auto height_px = number_of(request, "height", 16, 2048);
  if (!height_px) return api::answer(tl::unexpected<Error>(height_px.error()));
  const auto picture = check_.slice(plane->second, *position, static_cast<int>(*height_px));
  return api::png_answer(picture.view());
}

HttpResponse SkinCheckDesk::surface(const HttpRequest& request) const {
  const std::string of = text_of(request, "of");
  if (of == "skin") return {200, "application/octet-stream", bytes_of(check_.skin())};
  if (of == "doubtful") return {200, "application/octet-stream", bytes_of(check_.doubtful_skin())};
  const auto part = number_of(request, "of", 0.0, static_cast<double>(check_.parts().size()) - 1.0);
  if (!part) return api::answer(tl::unexpected<Error>(part.error()));
  return {200,
          "application/octet-stream",
          bytes_of(check_.part_surface(static_cast<std::size_t>(*part)))};
}

std::optional<PrepareSummary> SkinCheckDesk::wait(std::stop_token stop) {
  constexpr std::chrono::seconds kToTellThePage{3};
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return made_ || stage_ == Stage::kCancelled; });
  // The page is to hear how it ended before its server is gone.
  changed_.wait_for(lock, stop, kToTellThePage, [&] { return end_was_told_; });
  lock.unlock();
  worker_ = {};
  return made_;
}

}  // namespace mor
