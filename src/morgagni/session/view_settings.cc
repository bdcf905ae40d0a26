// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/view_settings.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string_view>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

using Json = nlohmann::json;

constexpr float kMaxHoleRadius = 2.0F;
constexpr float kMaxRim = 0.2F;
constexpr float kMaxSliceDepthMm = 600.0F;
constexpr float kLeastHu = -1024.0F;
constexpr float kMostHu = 3071.0F;
constexpr float kWidestHu = 8192.0F;
constexpr double kMostTurnRad = 1000.0;
constexpr double kMostPitchRad = 0.5 * std::numbers::pi;
constexpr double kLeastZoom = 0.3;
constexpr double kMostZoom = 20.0;
constexpr double kFarthestTargetMm = 3000.0;
constexpr std::array<std::string_view, 5> kPlaneNames = {
    "none", "axial", "coronal", "sagittal", "camera"};

tl::unexpected<Error> refuse(const std::string& sentence) {
  return make_error(ErrorCode::kInvalidArgument, sentence);
}

template <class T>
Result<void> set_number(T& value, const std::string& name, const Json& json, T least, T most) {
  if (!json.is_number() || !(json.get<T>() >= least && json.get<T>() <= most)) {
    return refuse(fmt::format(
        "{} must be a number from {:.6g} to {:.6g}, got {}", name, least, most, json.dump()));
  }
  value = json.get<T>();
  return {};
}

Result<void> set_share(float& value, const std::string& name, const Json& json) {
  return set_number(value, name, json, 0.0F, 1.0F);
}

Result<void> set_flag(bool& value, const std::string& name, const Json& json) {
  if (!json.is_boolean()) return refuse(fmt::format("{} must be true or false", name));
  value = json.get<bool>();
  return {};
}

/// Calls `set(look, value)` for each structure that is named.
Result<void> set_structures(
    ViewSettings& view,
    const std::string& member,
    const Json& json,
    const std::function<Result<void>(StructureLook&, const std::string&, const Json&)>& set) {
  if (!json.is_object()) return refuse(member + " must be an object with structures' names");
  for (const auto& [name, value] : json.items()) {
    const auto known = view.structures.find(name);
    if (known == view.structures.end()) {
      return refuse(fmt::format("the case has no structure \"{}\"", name));
    }
    MOR_CHECK(set(known->second, fmt::format("structure \"{}\"", name), value));
  }
  return {};
}

Result<void> check_ct(const ViewSettings& view) {
  if (view.has_ct) return {};
  return refuse(
      "this case was prepared without its CT's voxels: prepare it again to see slices and volume");
}

Result<void> set_plane(ViewSettings& view, const Json& json) {
  for (std::size_t i = 0; i < kPlaneNames.size(); ++i) {
    if (json != kPlaneNames[i]) continue;
    if (i != 0) MOR_CHECK(check_ct(view));
    view.slice.plane = static_cast<SlicePlane>(i);
    return {};
  }
  return refuse(
      fmt::format("slice must be none, axial, coronal, sagittal or camera, got {}", json.dump()));
}

/// With the preset comes its own window.
Result<void> set_preset(ViewSettings& view, const Json& json) {
  const auto preset =
      json.is_string() ? parse_volume_preset(json.get<std::string>()) : std::nullopt;
  if (!preset) {
    return refuse(fmt::format(
        "volume must be none, bone, soft-tissue, lung, vessels or skin, got {}", json.dump()));
  }
  if (*preset != VolumePreset::kNone) MOR_CHECK(check_ct(view));
  const auto [level_hu, window_hu] = volume_window(*preset);
  view.volume = {*preset, level_hu, window_hu};
  return {};
}

/// Negative: from white to black.
Result<void> set_slice_window(float& value, const std::string& name, const Json& json) {
  float window_hu = 0.0F;
  MOR_CHECK(set_number(window_hu, name, json, -kWidestHu, kWidestHu));
  if (std::abs(window_hu) < 1.0F) return refuse(name + " must be at least 1 HU wide");
  value = window_hu;
  return {};
}

Result<void> set_picture(ViewSettings& view, const Json& json) {
  if (json != "camera" && json != "free") {
    return refuse(fmt::format("picture must be camera or free, got {}", json.dump()));
  }
  view.free.is_shown = json == "free";
  return {};
}

Result<void> set_colors(ViewSettings& view, const Json& json) {
  if (json != "live" && json != "fused") {
    return refuse(fmt::format("free_colors must be live or fused, got {}", json.dump()));
  }
  view.free.wears_fused = json == "fused";
  return {};
}

Result<void> set_target(Eigen::Vector3d& target_mm, const std::string& name, const Json& json) {
  if (!json.is_array() || json.size() != 3) return refuse(name + " must be three numbers");
  for (int i = 0; i < 3; ++i) {
    MOR_CHECK(set_number(target_mm[i], name, json[i], -kFarthestTargetMm, kFarthestTargetMm));
  }
  return {};
}

Json triple(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

using Setter = std::function<Result<void>(ViewSettings&, const std::string&, const Json&)>;

Result<void> set_shown(StructureLook& look, const std::string& name, const Json& json) {
  return set_flag(look.is_shown, name, json);
}

Result<void> set_opacity(StructureLook& look, const std::string& name, const Json& json) {
  return set_share(look.opacity, "the opacity of " + name, json);
}

const std::map<std::string, Setter>& setters() {
  static const std::map<std::string, Setter> kSetters = {
      {"opacity", [](auto& v, auto& n, auto& j) { return set_share(v.opacity, n, j); }},
      {"hole_radius",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.hole.radius, n, j, 0.0F, kMaxHoleRadius);
       }},
      {"hole_rim",
       [](auto& v, auto& n, auto& j) { return set_number(v.hole.rim, n, j, 0.0F, kMaxRim); }},
      {"hole_x", [](auto& v, auto& n, auto& j) { return set_share(v.hole.center.x(), n, j); }},
      {"hole_y", [](auto& v, auto& n, auto& j) { return set_share(v.hole.center.y(), n, j); }},
      {"picture", [](auto& v, auto&, auto& j) { return set_picture(v, j); }},
      {"free_yaw",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.free.yaw_rad, n, j, -kMostTurnRad, kMostTurnRad);
       }},
      {"free_pitch",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.free.pitch_rad, n, j, -kMostPitchRad, kMostPitchRad);
       }},
      {"free_zoom",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.free.zoom, n, j, kLeastZoom, kMostZoom);
       }},
      {"free_target_mm",
       [](auto& v, auto& n, auto& j) { return set_target(v.free.target_mm, n, j); }},
      {"free_colors", [](auto& v, auto&, auto& j) { return set_colors(v, j); }},
      {"free_hole", [](auto& v, auto& n, auto& j) { return set_flag(v.free.opens_hole, n, j); }},
      {"free_bare_skin",
       [](auto& v, auto& n, auto& j) { return set_flag(v.free.shows_bare_skin, n, j); }},
      {"hands_in_front",
       [](auto& v, auto& n, auto& j) { return set_flag(v.keeps_hands_in_front, n, j); }},
      {"outlines", [](auto& v, auto& n, auto& j) { return set_flag(v.has_outlines, n, j); }},
      {"structures", [](auto& v, auto& n, auto& j) { return set_structures(v, n, j, set_shown); }},
      {"structure_opacity",
       [](auto& v, auto& n, auto& j) { return set_structures(v, n, j, set_opacity); }},
      {"slice", [](auto& v, auto&, auto& j) { return set_plane(v, j); }},
      {"slice_position",
       [](auto& v, auto& n, auto& j) { return set_share(v.slice.position, n, j); }},
      {"slice_depth_mm",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.slice.depth_mm, n, j, 0.0F, kMaxSliceDepthMm);
       }},
      {"slice_level_hu",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.slice.level_hu, n, j, kLeastHu, kMostHu);
       }},
      {"slice_window_hu",
       [](auto& v, auto& n, auto& j) { return set_slice_window(v.slice.window_hu, n, j); }},
      {"slice_opacity", [](auto& v, auto& n, auto& j) { return set_share(v.slice.opacity, n, j); }},
      {"slice_cuts", [](auto& v, auto& n, auto& j) { return set_flag(v.slice.cuts, n, j); }},
      {"volume", [](auto& v, auto&, auto& j) { return set_preset(v, j); }},
      {"volume_level_hu",
       [](auto& v, auto& n, auto& j) {
         return set_number(v.volume.level_hu, n, j, kLeastHu, kMostHu);
       }},
      {"volume_window_hu", [](auto& v, auto& n, auto& j) {
         return set_number(v.volume.window_hu, n, j, 1.0F, kWidestHu);
       }}};
  return kSetters;
}

}  // namespace

std::string to_json(const ViewSettings& view) {
  Json shown = Json::object();
  Json opacities = Json::object();
  for (const auto& [name, look] : view.structures) {
    shown[name] = look.is_shown;
    opacities[name] = look.opacity;
  }
  return Json{{"opacity", view.opacity},
              {"hole_radius", view.hole.radius},
              {"hole_rim", view.hole.rim},
              {"hole_x", view.hole.center.x()},
              {"hole_y", view.hole.center.y()},
              {"picture", view.free.is_shown ? "free" : "camera"},
              {"free_yaw", view.free.yaw_rad},
              {"free_pitch", view.free.pitch_rad},
              {"free_zoom", view.free.zoom},
              {"free_target_mm", triple(view.free.target_mm)},
              {"free_colors", view.free.wears_fused ? "fused" : "live"},
              {"free_hole", view.free.opens_hole},
              {"free_bare_skin", view.free.shows_bare_skin},
              {"hands_in_front", view.keeps_hands_in_front},
              {"outlines", view.has_outlines},
              {"structures", shown},
              {"structure_opacity", opacities},
              {"slice", kPlaneNames[static_cast<std::size_t>(view.slice.plane)]},
              {"slice_position", view.slice.position},
              {"slice_depth_mm", view.slice.depth_mm},
              {"slice_level_hu", view.slice.level_hu},
              {"slice_window_hu", view.slice.window_hu},
              {"slice_opacity", view.slice.opacity},
              {"slice_cuts", view.slice.cuts},
              {"volume", to_string(view.volume.preset)},
              {"volume_level_hu", view.volume.level_hu},
              {"volume_window_hu", view.volume.window_hu}}
      .dump();
}

Result<ViewSettings> changed(const ViewSettings& view, const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return refuse("the view must be a JSON object");
  ViewSettings result = view;
  // In the order of the names, so that a preset comes before a window of one's own.
  for (const auto& [name, value] : json.items()) {
    const auto setter = setters().find(name);
    if (setter == setters().end()) {
      return refuse(fmt::format("the view has no member \"{}\"", name));
    }
    // A view without a preset has no window that could be read back.
    const bool is_moot = name.starts_with("volume_") && result.volume.preset == VolumePreset::kNone;
    if (!is_moot) MOR_CHECK(setter->second(result, name, value));
  }
  return result;
}

}  // namespace mor
