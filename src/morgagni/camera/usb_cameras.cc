// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/usb_cameras.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace mor {
namespace {

namespace fs = std::filesystem;

struct Known {
  std::string_view id;  ///< Vendor and product; of a vendor all where it ends with ':'.
  std::string_view product;
  std::string_view camera;
};

// From the vendors' udev rules and linux-usb.org. The first that fits counts.
constexpr Known kKnown[] = {
    {"045e:02ae", "Kinect for Xbox 360", "freenect:"},
    {"045e:02bf", "Kinect for Windows v1", "freenect:"},
    {"045e:02c4", "Kinect for Xbox One", ""},
    {"045e:02d8", "Kinect for Xbox One", ""},
    {"045e:097c", "Azure Kinect", ""},
    {"1d27:", "PrimeSense's kind (Carmine, Asus Xtion, Structure)", "openni2:"},
    {"2bc5:", "Orbbec", ""},
    {"8086:0ad3", "RealSense D415", ""},
    {"8086:0b07", "RealSense D435", ""},
    {"8086:0b3a", "RealSense D435i", ""},
    {"8086:0b5c", "RealSense D455", ""},
};

std::string word_of(const fs::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
}

const Known* known(const std::string& id) {
  const auto found = std::ranges::find_if(kKnown, [&](const Known& each) {
    return each.id.ends_with(':') ? id.starts_with(each.id) : id == each.id;
  });
  return found == std::end(kKnown) ? nullptr : found;
}

/// The kernel numbers bus and device in three digits.
std::optional<fs::path> device_file(const fs::path& entry, const fs::path& devices) {
  const auto number = [&](const char* name) -> std::optional<int> {
    const auto word = word_of(entry / name);
    int value = 0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (status != std::errc() || end != word.data() + word.size()) return std::nullopt;
    return value;
  };
  const auto bus = number("busnum");
  const auto device = number("devnum");
  if (!bus || !device) return std::nullopt;
  return devices / fmt::format("{:03}", *bus) / fmt::format("{:03}", *device);
}

/// OpenNI2 asks the device itself, and libfreenect asks the microphones beside a Kinect whose
/// camera has zeros.
std::string device_id_of(const fs::path& entry, const UsbCamera& camera) {
  const auto serial = word_of(entry / "serial");
  if (camera.camera != "freenect:" || serial.find_first_not_of('0') == std::string::npos) return {};
  return "freenect-" + serial;
}

std::string advice_for(const UsbCamera& camera) {
  if (camera.product.starts_with("RealSense")) {
    return "where the kernel runs it, it is among the video devices (--camera v4l2:/dev/videoN); "
           "or push it with examples/push_realsense.py";
  }
  if (camera.camera.empty()) {
    return "Debian has no driver for it: push it with its maker's own (--camera push:8765; "
           "docs/cameras.md has scripts)";
  }
  if (camera.is_allowed) return {};
  return "this user may not use it: copy scripts/60-morgagni-cameras.rules to /etc/udev/rules.d, "
         "run `sudo udevadm control --reload`, and plug the camera in again";
}

}  // namespace

std::vector<UsbCamera> list_usb_cameras(const fs::path& sysfs, const fs::path& devices) {
  std::vector<UsbCamera> cameras;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(sysfs, status)) {
    const auto id = word_of(entry.path() / "idVendor") + ":" + word_of(entry.path() / "idProduct");
    const auto* kind = known(id);
    if (kind == nullptr) continue;
    UsbCamera camera{
        .product = std::string(kind->product), .id = id, .camera = std::string(kind->camera)};
    const auto file = device_file(entry.path(), devices);
    camera.is_allowed = file && access(file->c_str(), R_OK | W_OK) == 0;
    camera.advice = advice_for(camera);
    camera.device_id = device_id_of(entry.path(), camera);
    cameras.push_back(std::move(camera));
  }
  std::ranges::sort(cameras, {}, &UsbCamera::id);
  return cameras;
}

}  // namespace mor
