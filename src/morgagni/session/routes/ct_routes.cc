// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/ct_routes.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>

#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;

Json to_json(const CtChoice& cts) {
  return {{"names", cts.names}, {"shown", cts.shown}};
}

Result<Json> choose(const CtChoice& cts, const std::string& text) {
  MOR_TRY(const Json json, api::parse_object(text));
  const auto found = json.find("name");
  if (found == json.end() || !found->is_string()) return api::refuse("name must be a text");
  const auto name = found->get<std::string>();
  const bool is_there =
      name.empty() || std::find(cts.names.begin(), cts.names.end(), name) != cts.names.end();
  if (!is_there || !cts.choose) return api::refuse(fmt::format("the case has no CT \"{}\"", name));
  if (name != cts.shown) cts.choose(name);
  return Json::object();
}

}  // namespace

std::vector<HttpRoute> make_ct_routes(const CtChoice& cts) {
  return {api::get("/api/cts", [=](const HttpRequest&) { return api::answer(to_json(cts)); }),
          api::post("/api/cts/choose", [=](const auto& text) { return choose(cts, text); })};
}

}  // namespace mor
