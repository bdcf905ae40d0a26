// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mor {

/// A range camera on the USB bus, whether or not Morgagni has a driver for it.
struct UsbCamera {
  std::string product;      ///< "Kinect for Xbox 360".
  std::string id;           ///< "045e:02ae".
  std::string camera;       ///< What opens it: "freenect:". Empty: no driver.
  bool is_allowed = false;  ///< This user may use it.
  std::string advice = {};  ///< What to do before it can be used. Empty: nothing.
  /// As RangeCamera::device_id() of the driver. Empty: only opening it tells.
  std::string device_id = {};
};

/// Range cameras that are plugged in, as the kernel lists them; nothing is opened.
/// @param sysfs  Where the kernel's list is: /sys/bus/usb/devices.
/// @param devices  Where the devices' files are: /dev/bus/usb.
[[nodiscard]] std::vector<UsbCamera> list_usb_cameras(
    const std::filesystem::path& sysfs = "/sys/bus/usb/devices",
    const std::filesystem::path& devices = "/dev/bus/usb");

}  // namespace mor
