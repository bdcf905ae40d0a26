// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/simulated_camera.h"

namespace mor {
namespace {

using internal::KeyValue;

constexpr std::uint64_t kMaxFrames = 1'000'000'000;
constexpr std::uint64_t kMaxFramesAView = 1000;
constexpr double kLeastWalkMm = 10.0;
constexpr double kMostWalkMm = 1000.0;
constexpr double kMaxBiasMm = 20.0;
constexpr double kMaxFocalErrorPercent = 5.0;
constexpr double kMaxExposureSwing = 0.6;
constexpr double kMaxTableUnevenMm = 5.0;

/// The picture, its pace and the camera's way.
Result<bool> set_camera(const KeyValue& pair, SimulatedCameraOptions& options) {
  if (pair.key == "seed") {
    MOR_TRY(options.seed, internal::parse_count(pair, 0, UINT64_MAX));
  } else if (pair.key == "width") {
    MOR_TRY(const auto width, internal::parse_count(pair, 64, 1920));
    options.width_px = static_cast<int>(width);
  } else if (pair.key == "height") {
    MOR_TRY(const auto height, internal::parse_count(pair, 48, 1080));
    options.height_px = static_cast<int>(height);
  } else if (pair.key == "fps") {
    MOR_TRY(options.frames_per_s, internal::parse_number(pair, 1.0, 120.0));
  } else if (pair.key == "distance") {
    MOR_TRY(options.distance_mm, internal::parse_number(pair, 400.0, 1500.0));
  } else if (pair.key == "path") {
    MOR_TRY(const auto choice,
            internal::parse_choice(pair, {"orbit", "sway", "still", "views", "pass", "sweep"}));
    options.path = static_cast<SimulatedPath>(choice);
  } else if (pair.key == "hold") {
    MOR_TRY(options.frames_a_view, internal::parse_count(pair, 1, kMaxFramesAView));
  } else if (pair.key == "walk") {
    MOR_TRY(options.walk_mm, internal::parse_number(pair, kLeastWalkMm, kMostWalkMm));
  } else if (pair.key == "frames") {
    MOR_TRY(options.num_frames, internal::parse_count(pair, 0, kMaxFrames));
  } else if (pair.key == "speed") {
    MOR_TRY(const auto choice, internal::parse_choice(pair, {"real", "full"}));
    options.is_real_time = choice == 0;
  } else {
    return false;
  }
  return true;
}

/// What stands in the way of a good registration.
Result<bool> set_trouble(const KeyValue& pair, SimulatedCameraOptions& options) {
  if (pair.key == "clutter") {
    MOR_TRY(const auto choice,
            internal::parse_choice(pair, {"none", "hand", "towel", "parts", "all"}));
    options.clutter = static_cast<SimulatedClutter>(choice);
  } else if (pair.key == "bias") {
    MOR_TRY(options.bias_mm, internal::parse_number(pair, 0.0, kMaxBiasMm));
  } else if (pair.key == "focal") {
    MOR_TRY(options.focal_error_percent,
            internal::parse_number(pair, -kMaxFocalErrorPercent, kMaxFocalErrorPercent));
  } else if (pair.key == "exposure") {
    MOR_TRY(options.exposure_swing, internal::parse_number(pair, 0.0, kMaxExposureSwing));
  } else if (pair.key == "skin") {
    MOR_TRY(const auto choice, internal::parse_choice(pair, {"plain", "marked"}));
    options.skin = static_cast<SimulatedSkin>(choice);
  } else if (pair.key == "table") {
    MOR_TRY(options.table_uneven_mm, internal::parse_number(pair, 0.0, kMaxTableUnevenMm));
  } else if (pair.key == "noise") {
    MOR_TRY(const auto choice, internal::parse_choice(pair, {"0", "1"}));
    options.has_noise = choice == 1;
  } else {
    return false;
  }
  return true;
}

tl::unexpected<Error> outside(std::string_view what, double value, double least, double most) {
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{} must be in [{}, {}], got {}", what, least, most, value));
}

}  // namespace

Result<SimulatedCameraOptions> SimulatedCameraOptions::parse(std::string_view text) {
  SimulatedCameraOptions options;
  MOR_TRY(const auto pairs, internal::split_key_values(text));
  for (const auto& pair : pairs) {
    MOR_TRY(const bool is_camera_key, set_camera(pair, options));
    if (is_camera_key) continue;
    MOR_TRY(const bool is_trouble_key, set_trouble(pair, options));
    if (is_trouble_key) continue;
    return internal::unknown_key("simulated",
                                 pair,
                                 {"seed",
                                  "width",
                                  "height",
                                  "fps",
                                  "distance",
                                  "path",
                                  "hold",
                                  "walk",
                                  "clutter",
                                  "bias",
                                  "focal",
                                  "exposure",
                                  "skin",
                                  "table",
                                  "noise",
                                  "frames",
                                  "speed"});
  }
  return options;
}

Result<void> SimulatedCameraOptions::check() const {
  if (width_px < 64 || width_px > 1920) return outside("width", width_px, 64, 1920);
  if (height_px < 48 || height_px > 1080) return outside("height", height_px, 48, 1080);
  if (!(frames_per_s >= 1.0 && frames_per_s <= 120.0)) return outside("fps", frames_per_s, 1, 120);
  if (distance_mm && !(*distance_mm >= 400.0 && *distance_mm <= 1500.0)) {
    return outside("distance", *distance_mm, 400, 1500);
  }
  if (frames_a_view < 1 || frames_a_view > kMaxFramesAView) {
    return outside("hold", static_cast<double>(frames_a_view), 1, kMaxFramesAView);
  }
  if (walk_mm && !(*walk_mm >= kLeastWalkMm && *walk_mm <= kMostWalkMm)) {
    return outside("walk", *walk_mm, kLeastWalkMm, kMostWalkMm);
  }
  if (path != SimulatedPath::kViews && (frames_a_view != 1 || walk_mm)) {
    return make_error(ErrorCode::kInvalidArgument, "hold and walk are of path=views alone");
  }
  if (!(bias_mm >= 0.0 && bias_mm <= kMaxBiasMm)) return outside("bias", bias_mm, 0, kMaxBiasMm);
  if (!(std::abs(focal_error_percent) <= kMaxFocalErrorPercent)) {
    return outside("focal", focal_error_percent, -kMaxFocalErrorPercent, kMaxFocalErrorPercent);
  }
  if (!(exposure_swing >= 0.0 && exposure_swing <= kMaxExposureSwing)) {
    return outside("exposure", exposure_swing, 0, kMaxExposureSwing);
  }
  if (!(table_uneven_mm >= 0.0 && table_uneven_mm <= kMaxTableUnevenMm)) {
    return outside("table", table_uneven_mm, 0, kMaxTableUnevenMm);
  }
  return {};
}

}  // namespace mor
