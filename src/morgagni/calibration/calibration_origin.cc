// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/calibration_origin.h"

#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/camera/open_camera.h"
#include "morgagni/core/utc.h"

namespace mor {
namespace {

using std::chrono::system_clock;

constexpr std::chrono::hours kHalfAYear{24 * 182};

/// How it was found, by KeptCalibration::made_by.
std::string source_of(std::string_view made_by) {
  if (made_by == "board") return "found with a board";
  return std::string(made_by);
}

/// "board, 2026-01-31T10:00:00Z", as CalibrationStore::save() writes it: the time; what stands
/// before it stays.
std::optional<system_clock::time_point> take_time(std::string_view& origin) {
  const auto comma = origin.rfind(", ");
  if (comma == std::string_view::npos) return std::nullopt;
  const auto time = parse_utc(std::string(origin.substr(comma + 2)));
  if (!time) return std::nullopt;
  origin = origin.substr(0, comma);
  return *time;
}

/// What a person gives to `calibrate`: without a file that is in use, and without secrets.
std::string plain_name(std::string_view camera_name) {
  return std::string(camera_name.substr(0, camera_name.find_first_of(",")));
}

std::string hint_for(const CalibrationOrigin& origin,
                     const RgbdCalibration& calibration,
                     std::string_view camera_name,
                     system_clock::time_point now) {
  if (!is_device_camera(camera_name)) return {};
  if (calibration.origin.empty()) {
    return fmt::format(
        "not calibrated, which may cost millimetres: morgagni calibrate --camera {} --page",
        plain_name(camera_name));
  }
  if (origin.made_at && is_old_calibration(now - *origin.made_at)) {
    return fmt::format("more than half a year old: morgagni calibrate check --camera {}",
                       plain_name(camera_name));
  }
  return {};
}

}  // namespace

bool is_old_calibration(system_clock::duration age) {
  return age > kHalfAYear;
}

CalibrationOrigin calibration_origin(const RgbdCalibration& calibration,
                                     std::string_view camera_name,
                                     system_clock::time_point now) {
  CalibrationOrigin origin;
  std::string_view words = calibration.origin;
  origin.made_at = take_time(words);
  if (!words.empty()) {
    origin.source = source_of(words);
  } else if (is_device_camera(camera_name)) {
    origin.source = "the device's own word";
  } else {
    origin.source = camera_name.starts_with("simulated") ? "the simulation's" : "the recording's";
  }
  if (origin.made_at) origin.age = age_text(now - *origin.made_at);
  origin.is_depth_corrected = calibration.depth_correction != nullptr;
  origin.hint = hint_for(origin, calibration, camera_name, now);
  return origin;
}

}  // namespace mor
