// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/view_settings.h"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

using Json = nlohmann::json;

constexpr float kMaxHoleRadius = 2.0F;

tl::unexpected<Error> refuse(const std::string& sentence) {
  return make_error(ErrorCode::kInvalidArgument, sentence);
}

Result<void> set_share(float& value, const std::string& name, const Json& json, float most) {
  if (!json.is_number() || !(json.get<float>() >= 0.0F && json.get<float>() <= most)) {
    return refuse(fmt::format("{} must be a number from 0 to {}, got {}", name, most, json.dump()));
  }
  value = json.get<float>();
  return {};
}

Result<void> set_structures(std::map<std::string, bool>& structures, const Json& json) {
  if (!json.is_object()) return refuse("structures must be an object of true and false");
  for (const auto& [name, shown] : json.items()) {
    const auto known = structures.find(name);
    if (known == structures.end())
      return refuse(fmt::format("the case has no structure \"{}\"", name));
    if (!shown.is_boolean())
      return refuse(fmt::format("structure \"{}\" must be true or false", name));
    known->second = shown.get<bool>();
  }
  return {};
}

}  // namespace

std::string to_json(const ViewSettings& view) {
  return Json{{"opacity", view.opacity},
              {"hole_radius", view.hole.radius},
              {"hole_x", view.hole.center.x()},
              {"hole_y", view.hole.center.y()},
              {"structures", view.structures}}
      .dump();
}

Result<ViewSettings> changed(const ViewSettings& view, const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return refuse("the view must be a JSON object");
  ViewSettings result = view;
  for (const auto& [name, value] : json.items()) {
    if (name == "opacity") {
      MOR_CHECK(set_share(result.opacity, name, value, 1.0F));
    } else if (name == "hole_radius") {
      MOR_CHECK(set_share(result.hole.radius, name, value, kMaxHoleRadius));
    } else if (name == "hole_x") {
      MOR_CHECK(set_share(result.hole.center.x(), name, value, 1.0F));
    } else if (name == "hole_y") {
      MOR_CHECK(set_share(result.hole.center.y(), name, value, 1.0F));
    } else if (name == "structures") {
      MOR_CHECK(set_structures(result.structures, value));
    } else {
      return refuse(fmt::format("the view has no member \"{}\"", name));
    }
  }
  return result;
}

}  // namespace mor
