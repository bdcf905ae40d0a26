// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/camera/range_camera.h"

namespace mor {

namespace internal {
class VideoSystem;
}

/// What `v4l2:/dev/videoN,key=value,...` sets; the keys stand in brackets.
struct V4l2Options {
  std::string depth_device;       ///< "/dev/video0".
  std::string color_device = {};  ///< [color] Without it, the picture shows the depth in grey.
  /// [calibration] A JSON file (calibration_json.h). Without it, the design of a RealSense D435 is
  /// taken, which no other camera has.
  std::string calibration_file = {};
  /// [device] Under which a calibration is kept, in place of the id that the camera gives.
  std::string device_id = {};
  bool is_y16 =
      false;  ///< [format=z16|y16] Depth comes as Y16, which most cameras use for infrared.
  /// Asked by the serial number of the USB device; where it has none, by the kernel's word of the
  /// place on the bus, which another plug changes.
  KnownCalibration known = {};
  std::filesystem::path sysfs = "/sys/class/video4linux";  ///< Where the kernel lists the devices.

  [[nodiscard]] static Result<V4l2Options> parse(std::string_view text);
};

/// A depth camera that the kernel's own driver (uvcvideo) runs: 16-bit millimetres, and colour from
/// another video device, paired by the drivers' stamps. It ends with kDevice when the device is
/// gone, and is opened anew by its watchdog.
/// @errors kNotFound, kDevice (no permission, in use, no depth format: says which it has),
/// kInvalidArgument (calibration file).
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_v4l2(
    const V4l2Options& options, std::shared_ptr<const internal::VideoSystem> system = nullptr);

/// A video device of this machine that gives depth, or may not be looked at.
struct DepthVideoDevice {
  std::string path;    ///< "/dev/video0".
  std::string card;    ///< What its driver calls it. Empty: it may not be looked at.
  std::string camera;  ///< What opens it: "v4l2:/dev/video0,color=/dev/video4". Empty: nothing.
  std::string advice;  ///< What to do before it can be used. Empty: nothing.
  std::string device_id = {};  ///< RangeCamera::device_id() of it.
};

/// @param folder  Where the devices' files are: /dev.
[[nodiscard]] std::vector<DepthVideoDevice> list_depth_video_devices(
    const std::filesystem::path& folder = "/dev",
    const std::filesystem::path& sysfs = V4l2Options{}.sysfs,
    std::shared_ptr<const internal::VideoSystem> system = nullptr);

}  // namespace mor
