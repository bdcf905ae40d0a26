// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/calibration_json.h"

#include <cmath>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/printable_text.h"

namespace mor {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMaxRotationError = 1e-6;
constexpr std::size_t kMaxOriginBytes = 1000;

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, "calibration: " + std::move(message));
}

Json pinhole_json(const PinholeCamera& camera) {
  return {{"width", camera.width_px},
          {"height", camera.height_px},
          {"fx", camera.focal_x_px},
          {"fy", camera.focal_y_px},
          {"cx", camera.center_x_px},
          {"cy", camera.center_y_px},
          {"distortion", camera.distortion}};
}

Result<double> finite(const Json& value, const std::string& name) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    return bad(name + " is no finite number");
  }
  return value.get<double>();
}

Result<double> member(const Json& json, const std::string& camera, const char* key) {
  const auto value = json.find(key);
  if (value == json.end()) return bad(fmt::format("{} has no {}", camera, key));
  return finite(*value, camera + "." + key);
}

Result<int> size_px(const Json& json, const std::string& camera, const char* key) {
  MOR_TRY(const double value, member(json, camera, key));
  if (!(value >= 1.0 && value <= 16384.0 && value == std::floor(value))) {
    return bad(fmt::format("{}.{} must be a whole number in [1, 16384]", camera, key));
  }
  return static_cast<int>(value);
}

Result<PinholeCamera> parse_pinhole(const Json& root, const std::string& name) {
  const auto json = root.find(name);
  if (json == root.end() || !json->is_object()) return bad("has no " + name);
  PinholeCamera camera;
  MOR_TRY(camera.width_px, size_px(*json, name, "width"));
  MOR_TRY(camera.height_px, size_px(*json, name, "height"));
  MOR_TRY(camera.focal_x_px, member(*json, name, "fx"));
  MOR_TRY(camera.focal_y_px, member(*json, name, "fy"));
  MOR_TRY(camera.center_x_px, member(*json, name, "cx"));
  MOR_TRY(camera.center_y_px, member(*json, name, "cy"));
  const auto distortion = json->find("distortion");
  if (distortion == json->end() || !distortion->is_array() ||
      distortion->size() != camera.distortion.size()) {
    return bad(name + ".distortion must hold five numbers: k1, k2, p1, p2, k3");
  }
  for (std::size_t i = 0; i < camera.distortion.size(); ++i) {
    MOR_TRY(camera.distortion[i], finite((*distortion)[i], name + ".distortion"));
  }
  if (const auto checked = camera.check(); !checked) {
    return bad(fmt::format("{}: {}", name, checked.error().message));
  }
  return camera;
}

Result<Eigen::Isometry3d> parse_rigid(const Json& root, const std::string& name) {
  const auto rows = root.find(name);
  if (rows == root.end() || !rows->is_array() || rows->size() != 3) {
    return bad(name + " must hold three rows of four numbers");
  }
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  for (int y = 0; y < 3; ++y) {
    const auto& row = (*rows)[static_cast<std::size_t>(y)];
    if (!row.is_array() || row.size() != 4) {
      return bad(name + " must hold three rows of four numbers");
    }
    for (int x = 0; x < 4; ++x) {
      MOR_TRY(result.matrix()(y, x), finite(row[static_cast<std::size_t>(x)], name));
    }
  }
  const Eigen::Matrix3d turned_back = result.linear() * result.linear().transpose();
  if (!((turned_back - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kMaxRotationError) ||
      result.linear().determinant() < 0.0) {
    return bad(name + " is no rotation and shift");
  }
  return result;
}

constexpr const char* kDepthSd = "depth_sd";

Result<PinholeSd> parse_pinhole_sd(const Json& json) {
  if (!json.is_object()) return bad(std::string(kDepthSd) + " is no JSON object");
  PinholeSd sd;
  MOR_TRY(sd.focal_ratio, member(json, kDepthSd, "focal_ratio"));
  MOR_TRY(sd.center_px, member(json, kDepthSd, "center_px"));
  if (!(sd.focal_ratio > 0.0 && sd.focal_ratio <= 0.1) ||
      !(sd.center_px > 0.0 && sd.center_px <= 100.0)) {
    return bad(
        fmt::format("{}: focal_ratio must be in (0, 0.1], got {}, center_px in (0, 100], got {}",
                    kDepthSd,
                    sd.focal_ratio,
                    sd.center_px));
  }
  return sd;
}

Json correction_json(const DepthCorrection& correction) {
  Json c0 = Json::array();
  Json c1 = Json::array();
  Json c2 = Json::array();
  for (const auto& point : correction.control) {
    c0.push_back(point.c0_mm);
    c1.push_back(point.c1);
    c2.push_back(point.c2_per_mm);
  }
  Json json = {{"near_mm", correction.near_mm},
               {"far_mm", correction.far_mm},
               {"columns", correction.columns},
               {"rows", correction.rows},
               {"c0_mm", c0},
               {"c1", c1},
               {"c2_per_mm", c2}};
  if (!correction.curve.empty()) {
    Json& curve = json["curve"] = Json::array();
    for (const auto& knot : correction.curve) curve.push_back({knot.z_mm, knot.add_mm});
  }
  return json;
}

constexpr const char* kCorrection = "depth_correction";

Result<std::vector<double>> numbers(const Json& json, const char* key, std::size_t count) {
  const auto values = json.find(key);
  if (values == json.end() || !values->is_array() || values->size() != count) {
    return bad(fmt::format("{}.{} must hold {} numbers", kCorrection, key, count));
  }
  std::vector<double> result;
  for (const auto& value : *values) {
    MOR_TRY(const double number, finite(value, fmt::format("{}.{}", kCorrection, key)));
    result.push_back(number);
  }
  return result;
}

Result<std::vector<DepthCorrection::Knot>> parse_curve(const Json& json) {
  std::vector<DepthCorrection::Knot> curve;
  const auto knots = json.find("curve");
  if (knots == json.end()) return curve;
  const std::string name = std::string(kCorrection) + ".curve";
  if (!knots->is_array()) return bad(name + " must hold pairs of z_mm and add_mm");
  for (const auto& knot : *knots) {
    if (!knot.is_array() || knot.size() != 2) {
      return bad(name + " must hold pairs of z_mm and add_mm");
    }
    MOR_TRY(const double z_mm, finite(knot[0], name));
    MOR_TRY(const double add_mm, finite(knot[1], name));
    curve.push_back({z_mm, add_mm});
  }
  return curve;
}

Result<DepthCorrection> parse_correction(const Json& json) {
  if (!json.is_object()) return bad(std::string(kCorrection) + " is no JSON object");
  DepthCorrection correction;
  MOR_TRY(correction.near_mm, member(json, kCorrection, "near_mm"));
  MOR_TRY(correction.far_mm, member(json, kCorrection, "far_mm"));
  MOR_TRY(correction.columns, size_px(json, kCorrection, "columns"));
  MOR_TRY(correction.rows, size_px(json, kCorrection, "rows"));
  const auto count =
      static_cast<std::size_t>(correction.columns) * static_cast<std::size_t>(correction.rows);
  MOR_TRY(const auto c0, numbers(json, "c0_mm", count));
  MOR_TRY(const auto c1, numbers(json, "c1", count));
  MOR_TRY(const auto c2, numbers(json, "c2_per_mm", count));
  correction.control.clear();
  for (std::size_t i = 0; i < count; ++i) correction.control.push_back({c0[i], c1[i], c2[i]});
  MOR_TRY(correction.curve, parse_curve(json));
  MOR_CHECK(correction.check());
  return correction;
}

}  // namespace

std::string depth_correction_to_json(const DepthCorrection& correction) {
  return correction_json(correction).dump(1) + "\n";
}

Result<DepthCorrection> depth_correction_from_json(std::string_view text) {
  return parse_correction(Json::parse(text, nullptr, /*allow_exceptions=*/false));
}

std::string calibration_to_json(const RgbdCalibration& calibration) {
  Json rows = Json::array();
  for (int y = 0; y < 3; ++y) {
    const Eigen::Vector4d row = calibration.color_from_depth.matrix().row(y);
    rows.push_back({row[0], row[1], row[2], row[3]});
  }
  Json json = {{"depth", pinhole_json(calibration.depth)},
               {"color", pinhole_json(calibration.color)},
               {"color_from_depth", rows}};
  if (!calibration.origin.empty()) json["origin"] = printable_text(calibration.origin);
  if (const auto& sd = calibration.depth_sd) {
    json[kDepthSd] = {{"focal_ratio", sd->focal_ratio}, {"center_px", sd->center_px}};
  }
  if (calibration.depth_correction) {
    json[kCorrection] = correction_json(*calibration.depth_correction);
  }
  return json.dump(1) + "\n";
}

Result<RgbdCalibration> calibration_from_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return bad("is no JSON object");
  RgbdCalibration calibration;
  MOR_TRY(calibration.depth, parse_pinhole(json, "depth"));
  MOR_TRY(calibration.color, parse_pinhole(json, "color"));
  MOR_TRY(calibration.color_from_depth, parse_rigid(json, "color_from_depth"));
  if (const auto origin = json.find("origin"); origin != json.end()) {
    if (!origin->is_string() || origin->get_ref<const std::string&>().size() > kMaxOriginBytes) {
      return bad(fmt::format("origin must be a text of at most {} bytes", kMaxOriginBytes));
    }
    calibration.origin = origin->get<std::string>();
  }
  if (const auto sd = json.find(kDepthSd); sd != json.end()) {
    MOR_TRY(calibration.depth_sd, parse_pinhole_sd(*sd));
  }
  if (const auto correction = json.find(kCorrection); correction != json.end()) {
    MOR_TRY(auto parsed, parse_correction(*correction));
    calibration.depth_correction = std::make_shared<const DepthCorrection>(std::move(parsed));
  }
  return calibration;
}

}  // namespace mor
