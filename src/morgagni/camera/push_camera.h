// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "morgagni/camera/open_camera.h"
#include "morgagni/camera/range_camera.h"

namespace mor {

/// What `push:[HOST:]PORT,key=value,...` sets; the keys stand in brackets.
struct PushOptions {
  std::string host = "127.0.0.1";  ///< An IP address of this machine.
  std::uint16_t port = 0;          ///< 0: a free one, which the log names.
  std::string token = {};          ///< [token] What a device must say. At least 8 characters.
  /// [calibration] A JSON file (calibration_json.h); without it, the device sends CameraInfo.
  std::string calibration_file = {};
  /// [device] Under which a calibration is kept, in place of what the device calls itself.
  std::string device_id = {};
  KnownCalibration known = {};              ///< Asked where there is no calibration file.
  std::chrono::milliseconds tolerance{20};  ///< [tolerance_ms] Stamps of a pair, apart. 1..1000.

  [[nodiscard]] static Result<PushOptions> parse(std::string_view text);
};

/// A camera that any device on the network pushes: a WebSocket server that speaks the Foxglove
/// protocol's clientPublish and takes ROS 2 messages (docs/cameras.md). Depth and colour are paired
/// by their stamps, and the newest pair wins. `captured_at` is when a pair had come; the device's
/// own clock is `device_time`.
///
/// Returns when the first frame has come, or at once where the calibration comes from a file. It
/// is watched (watched_camera.h): a device that goes, and garbage, are said and waited over.
/// @errors kInvalidArgument (options, calibration file), kDevice (the port is in use), kCancelled
/// (`stop` was requested before a device came).
/// @param say  Told what it waits for, each time that changes.
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_push(const PushOptions& options,
                                                             std::stop_token stop,
                                                             const SayWaiting& say = {});

}  // namespace mor
