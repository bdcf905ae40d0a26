// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// Where the calibration that a camera sees by is from, for people.
struct CalibrationOrigin {
  std::string source;  ///< "found with a board", "the device's own word", "cal.json".
  std::optional<std::chrono::system_clock::time_point> made_at;  ///< None: no day is known.
  std::string age = {};                                          ///< "12 days old". Empty: none.
  bool is_depth_corrected = false;
  std::string hint = {};  ///< What to do about it. Empty: nothing.
};

/// @param camera_name  As open_camera() takes it. Only a device is hinted about: a simulation and a
/// recording are what they are.
[[nodiscard]] CalibrationOrigin calibration_origin(const RgbdCalibration& calibration,
                                                   std::string_view camera_name,
                                                   std::chrono::system_clock::time_point now);

/// Whether it was made so long ago that it wants to be checked: half a year.
[[nodiscard]] bool is_old_calibration(std::chrono::system_clock::duration age);

}  // namespace mor
