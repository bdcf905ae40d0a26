// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// What `freenect:key=value,...` sets; the keys stand in brackets.
struct FreenectOptions {
  int index = 0;  ///< [index] Of several Kinects, in the order of the USB bus. 0..15.
  /// [calibration] A JSON file (calibration_json.h); without it, the device's own memory gives the
  /// triangulation and the design the rest.
  std::string calibration_file = {};
  /// [device] Under which a calibration is kept, in place of the id that the camera gives.
  std::string device_id = {};
  /// What is loaded: libfreenect, or a library with its functions.
  std::string library = "libfreenect.so.0.5";
  KnownCalibration known = {};  ///< Asked where there is no calibration file.

  [[nodiscard]] static Result<FreenectOptions> parse(std::string_view text);
};

/// A Kinect for Xbox 360 (or Kinect for Windows v1) through libfreenect: raw 11-bit depth, turned
/// to millimetres here, and colour, 640x480 each, paired by the device's clock. Depth and colour
/// stay as they were; the calibration says how they lie to each other.
///
/// It ends with kDevice when the device is gone, and is opened anew by its watchdog.
/// @errors kNotFound (no library, no Kinect: says what to install or to plug in), kDevice (in use,
/// no permission), kInvalidArgument (calibration file).
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_freenect(const FreenectOptions& options);

/// How many Kinects are plugged in. @errors As open_freenect().
[[nodiscard]] Result<int> count_freenect_devices(const std::string& library);

}  // namespace mor
