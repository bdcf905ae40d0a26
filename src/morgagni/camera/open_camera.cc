// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/camera/simulated_camera.h"
#include "morgagni/camera/tum_player.h"

namespace mor {
namespace {

Result<std::unique_ptr<RangeCamera>> open_tum(std::string_view rest) {
  const auto comma = rest.find(',');
  const auto folder = rest.substr(0, comma);
  const auto text = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
  if (folder.empty()) {
    return make_error(ErrorCode::kInvalidArgument, "camera 'tum:' needs a folder: tum:DIR");
  }
  TumPlayerOptions options;
  MOR_TRY(const auto pairs, internal::split_key_values(text));
  for (const auto& pair : pairs) {
    if (pair.key == "loop") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"0", "1"}));
      options.is_looped = choice == 1;
    } else if (pair.key == "speed") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"real", "full"}));
      options.is_real_time = choice == 0;
    } else {
      return internal::unknown_key("tum", pair, {"loop", "speed"});
    }
  }
  MOR_TRY(auto recording, TumRecording::open(std::filesystem::path(folder)));
  return play_recording(std::move(recording), options);
}

}  // namespace

Result<std::unique_ptr<RangeCamera>> open_camera(const std::string& name,
                                                 std::shared_ptr<const TriangleMesh> skin) {
  const auto colon = name.find(':');
  const std::string_view kind = std::string_view(name).substr(0, colon);
  const std::string_view rest =
      colon == std::string::npos ? std::string_view() : std::string_view(name).substr(colon + 1);
  if (colon != std::string::npos && kind == "tum") return open_tum(rest);
  if (colon != std::string::npos && kind == "simulated") {
    MOR_TRY(const auto options, SimulatedCameraOptions::parse(rest));
    MOR_TRY(auto camera, SimulatedCamera::create(std::move(skin), options));
    return std::unique_ptr<RangeCamera>(std::move(camera));
  }
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("camera '{}' is unknown, there are simulated:[key=value,...] and tum:DIR", name));
}

}  // namespace mor
