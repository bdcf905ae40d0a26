// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// What `openni2:[FILE.oni][,key=value,...]` sets; the keys stand in brackets.
struct Openni2Options {
  std::string uri =
      {};  ///< A recording's path, or OpenNI's name of a device. Empty: the first device.
  std::string calibration_file = {};  ///< [calibration] A JSON file (calibration_json.h). Without
                                      ///< it, the driver's fields of view and the design's 25 mm.
  /// [device] Under which a calibration is kept, in place of the id that the camera gives.
  std::string device_id = {};
  std::string library = "libOpenNI2.so.0";  ///< What is loaded.
  KnownCalibration known = {};              ///< Asked where there is no calibration file.

  [[nodiscard]] static Result<Openni2Options> parse(std::string_view text);
};

/// A camera of PrimeSense's kind (Xtion, Carmine, Structure) or an .oni recording, through OpenNI2:
/// depth in millimetres and colour as they were, never mirrored, never warped onto each other. A
/// recording ends; a device that is gone is kDevice.
/// @errors kNotFound (no library, no device, no file), kDevice (cannot be opened, has no depth or
/// no colour in a form we read), kInvalidArgument (calibration file).
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_openni2(const Openni2Options& options);

}  // namespace mor
