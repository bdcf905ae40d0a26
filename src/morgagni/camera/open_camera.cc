// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/open_camera.h"

#include <algorithm>
#include <chrono>
#include <filesystem>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/freenect_camera.h"
#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/internal/wait_until.h"
#include "morgagni/camera/mcap_recording.h"
#include "morgagni/camera/openni2_camera.h"
#include "morgagni/camera/push_camera.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/camera/simulated_camera.h"
#include "morgagni/camera/tum_recording.h"
#include "morgagni/camera/v4l2_camera.h"
#include "morgagni/camera/watched_camera.h"

namespace mor {
namespace {

/// What stands behind the name of a recording: `PATH[,loop=1][,speed=real|full]`.
struct RecordingName {
  std::filesystem::path path;
  RecordingPlayerOptions options;
};

Result<RecordingName> parse_recording_name(std::string_view kind, std::string_view rest) {
  const auto comma = rest.find(',');
  const auto path = rest.substr(0, comma);
  const auto text = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
  if (path.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      kind == "tum" ? "camera 'tum:' needs a folder: tum:DIR"
                                    : "camera 'mcap:' needs a file: mcap:FILE");
  }
  RecordingName name{path, {}};
  MOR_TRY(const auto pairs, internal::split_key_values(text));
  for (const auto& pair : pairs) {
    if (pair.key == "loop") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"0", "1"}));
      name.options.is_looped = choice == 1;
    } else if (pair.key == "speed") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"real", "full"}));
      name.options.is_real_time = choice == 0;
    } else {
      return internal::unknown_key(kind, pair, {"loop", "speed"});
    }
  }
  return name;
}

template <class T>
Result<std::unique_ptr<RangeCamera>> open_recording(std::string_view kind, std::string_view rest) {
  MOR_TRY(const auto name, parse_recording_name(kind, rest));
  MOR_TRY(auto recording, T::open(name.path));
  return play_recording(std::make_unique<const T>(std::move(recording)), name.options);
}

/// Opens it as soon as it can be opened.
Result<std::unique_ptr<RangeCamera>> watch_from_when_it_is_there(CameraOpener open,
                                                                 const std::stop_token& stop,
                                                                 const SayWaiting& say) {
  constexpr std::chrono::milliseconds kRetry{500};
  std::string said;
  while (true) {
    auto camera = watch_camera(open);
    const bool may_come = !camera && (camera.error().code == ErrorCode::kDevice ||
                                      camera.error().code == ErrorCode::kNotFound);
    if (!may_come || !say) return camera;
    if (camera.error().message != said) say(camera.error().message);
    said = camera.error().message;
    internal::wait_until(std::chrono::steady_clock::now() + kRetry, stop);
    if (stop.stop_requested()) {
      return make_error(ErrorCode::kCancelled, "stopped before the camera came: " + said);
    }
  }
}

/// A file that is missing will not come by being waited for.
Result<void> check_calibration_file(const std::string& file) {
  if (file.empty() || std::filesystem::exists(file)) return {};
  return make_error(ErrorCode::kNotFound, fmt::format("{}: no such file", file));
}

}  // namespace

std::string shown_camera_name(std::string name) {
  constexpr std::string_view kToken = ",token=";
  const auto key = name.find(kToken);
  if (key == std::string::npos) return name;
  const auto value = key + kToken.size();
  return name.replace(value, std::min(name.find(',', value), name.size()) - value, "...");
}

bool is_device_camera(std::string_view name) {
  const auto rest = name.substr(std::min(name.find(':'), name.size()));
  const auto kind = name.substr(0, name.size() - rest.size());
  // An .oni file is a recording.
  if (kind == "openni2") return !rest.empty() && !rest.substr(0, rest.find(',')).ends_with(".oni");
  return !rest.empty() && (kind == "freenect" || kind == "push" || kind == "v4l2");
}

Result<std::unique_ptr<RangeCamera>> open_camera(const std::string& name,
                                                 std::shared_ptr<const TriangleMesh> skin,
                                                 const KnownCalibration& known) {
  return open_camera(name, std::move(skin), std::stop_token(), known);
}

Result<std::unique_ptr<RangeCamera>> open_camera(const std::string& name,
                                                 std::shared_ptr<const TriangleMesh> skin,
                                                 std::stop_token stop,
                                                 const KnownCalibration& known,
                                                 const SayWaiting& say) {
  const auto colon = name.find(':');
  const std::string_view kind = std::string_view(name).substr(0, colon);
  const std::string_view rest =
      colon == std::string::npos ? std::string_view() : std::string_view(name).substr(colon + 1);
  if (colon != std::string::npos && kind == "freenect") {
    MOR_TRY(auto options, FreenectOptions::parse(rest));
    options.known = known;
    MOR_CHECK(check_calibration_file(options.calibration_file));
    return watch_from_when_it_is_there([options] { return open_freenect(options); }, stop, say);
  }
  if (colon != std::string::npos && kind == "openni2") {
    MOR_TRY(auto options, Openni2Options::parse(rest));
    options.known = known;
    // A recording ends; a device is to come back.
    if (options.uri.ends_with(".oni")) return open_openni2(options);
    MOR_CHECK(check_calibration_file(options.calibration_file));
    return watch_from_when_it_is_there([options] { return open_openni2(options); }, stop, say);
  }
  if (colon != std::string::npos && kind == "v4l2") {
    MOR_TRY(auto options, V4l2Options::parse(rest));
    options.known = known;
    MOR_CHECK(check_calibration_file(options.calibration_file));
    return watch_from_when_it_is_there([options] { return open_v4l2(options); }, stop, say);
  }
  if (colon != std::string::npos && kind == "push") {
    MOR_TRY(auto options, PushOptions::parse(rest));
    options.known = known;
    return open_push(options, std::move(stop), say);
  }
  if (colon != std::string::npos && kind == "tum") return open_recording<TumRecording>(kind, rest);
  if (colon != std::string::npos && kind == "mcap") {
    return open_recording<McapRecording>(kind, rest);
  }
  if (colon != std::string::npos && kind == "simulated") {
    MOR_TRY(const auto options, SimulatedCameraOptions::parse(rest));
    MOR_TRY(auto camera, SimulatedCamera::create(std::move(skin), options));
    return std::unique_ptr<RangeCamera>(std::move(camera));
  }
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("camera '{}' is unknown, there are freenect:, mcap:FILE, openni2:, "
                  "push:PORT, simulated:[key=value,...], tum:DIR and v4l2:/dev/videoN",
                  name));
}

}  // namespace mor
