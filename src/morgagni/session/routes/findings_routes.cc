// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/findings_routes.h"

#include <cmath>

#include "morgagni/documentation/findings_io.h"
#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;
using api::refuse;

Result<std::string> text(const Json& json, const std::string& name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_string()) return refuse(name + " must be a text");
  return found->get<std::string>();
}

std::string_view name_of(PickedThing thing) {
  switch (thing) {
    case PickedThing::kSkin:
      return "skin";
    case PickedThing::kStructure:
      return "structure";
    case PickedThing::kSlice:
      return "slice";
    case PickedThing::kVolume:
      return "volume";
  }
  return "";
}

Json to_json(const FindingPoint& point) {
  return {{"ct_mm", api::to_json(point.ct_mm)},
          {"on_skin", point.is_on_skin},
          {"bound_mm", api::or_null(point.bound_mm)}};
}

Json to_json(const Finding& finding) {
  Json points = Json::array();
  for (const auto& point : finding.points) points.push_back(to_json(point));
  return {{"id", finding.id},
          {"kind", to_string(finding.kind)},
          {"note", finding.note},
          {"points", points},
          {"length_mm", api::or_null(finding.length_mm)},
          {"length_bound_mm", api::or_null(finding.length_bound_mm)},
          {"created_at", finding.created_at},
          {"has_photo", !finding.photo.empty()}};
}

Result<Json> list(const FindingsDesk& desk) {
  MOR_TRY(const auto findings, desk.findings());
  Json items = Json::array();
  for (const auto& finding : findings) items.push_back(to_json(finding));
  const std::string undoable = desk.undoable();
  return Json{{"findings", items}, {"undoable", undoable.empty() ? Json(nullptr) : Json(undoable)}};
}

Result<Json> pick(FindingsDesk& desk, const std::string& body) {
  MOR_TRY(const Json json, api::parse_object(body));
  MOR_TRY(const double x, api::number(json, "x"));
  MOR_TRY(const double y, api::number(json, "y"));
  std::optional<std::uint64_t> frame_id;
  if (const auto found = json.find("frame_id"); found != json.end() && !found->is_null()) {
    if (!found->is_number_unsigned()) return refuse("frame_id must be a whole number");
    frame_id = found->get<std::uint64_t>();
  }
  MOR_TRY(const auto picked, desk.pick({x, y}, frame_id));
  Json answer = to_json(picked.point);
  answer["pick"] = picked.number;
  answer["on"] = name_of(picked.seen.thing);
  answer["structure"] = picked.seen.structure;
  return answer;
}

Result<Json> add(FindingsDesk& desk, const std::string& body) {
  MOR_TRY(const Json json, api::parse_object(body));
  MOR_TRY(const auto kind_name, text(json, "kind"));
  const auto kind = parse_finding_kind(kind_name);
  if (!kind) return refuse("kind must be point, distance or geodesic");
  const std::string note = json.contains("note") && json["note"].is_string()
                               ? json["note"].get<std::string>()
                               : std::string();
  const auto numbers = json.find("picks");
  if (numbers == json.end() || !numbers->is_array() || numbers->size() > 2)
    return refuse("picks must be a list of one or two numbers");
  std::vector<int> picks;
  for (const auto& number : *numbers) {
    if (!number.is_number_integer()) return refuse("picks must be a list of one or two numbers");
    picks.push_back(number.get<int>());
  }
  MOR_TRY(const auto finding, desk.add(*kind, picks, note));
  return to_json(finding);
}

Result<Json> set_note(FindingsDesk& desk, const std::string& body) {
  MOR_TRY(const Json json, api::parse_object(body));
  MOR_TRY(const auto id, text(json, "id"));
  MOR_TRY(const auto note, text(json, "note"));
  MOR_CHECK(desk.set_note(id, note));
  return list(desk);
}

Result<Json> remove(FindingsDesk& desk, const std::string& body) {
  MOR_TRY(const Json json, api::parse_object(body));
  MOR_TRY(const auto id, text(json, "id"));
  MOR_CHECK(desk.remove(id));
  return list(desk);
}

Result<Json> undo(FindingsDesk& desk) {
  MOR_CHECK(desk.undo());
  return list(desk);
}

HttpResponse photo(const FindingsDesk& desk, const HttpRequest& request) {
  const auto id = request.query.find("id");
  const bool overlay = request.query.contains("overlay");
  const auto bytes = desk.photo(id == request.query.end() ? "" : id->second, overlay);
  if (!bytes) return api::answer(tl::unexpected<Error>(bytes.error()));
  return {
      200, "image/png", std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())};
}

}  // namespace

std::vector<HttpRoute> make_findings_routes(std::shared_ptr<FindingsDesk> desk) {
  return {api::get("/api/findings", [=](const HttpRequest&) { return api::answer(list(*desk)); }),
          api::get("/api/findings/photo.png",
                   [=](const HttpRequest& request) { return photo(*desk, request); }),
          api::post("/api/findings/pick", [=](const auto& body) { return pick(*desk, body); }),
          api::post("/api/findings/cancel",
                    [=](const auto&) -> Result<Json> {
                      desk->forget_picks();
                      return Json::object();
                    }),
          api::post("/api/findings/add", [=](const auto& body) { return add(*desk, body); }),
          api::post("/api/findings/note", [=](const auto& body) { return set_note(*desk, body); }),
          api::post("/api/findings/delete", [=](const auto& body) { return remove(*desk, body); }),
          api::post("/api/findings/undo", [=](const auto&) { return undo(*desk); })};
}

}  // namespace mor
