// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/calibration_origin.h"
#include "morgagni/calibration/calibration_store.h"
#include "morgagni/camera/freenect_camera.h"
#include "morgagni/camera/usb_cameras.h"
#include "morgagni/camera/v4l2_camera.h"
#include "morgagni/compute/compute_device.h"
#include "morgagni/core/version.h"
#include "morgagni/ct/volume_import.h"
#include "morgagni/render/overlay_renderer.h"

#include "commands.h"

namespace mor {
namespace {

/// What this machine offers to the program.
struct Findings {
  std::vector<ComputeDevice> opencl_devices;
  std::string opencl_advice;  ///< Where there is no device.
  Result<std::string> opengl_device;
  std::vector<UsbCamera> cameras;
  Result<int> num_kinects;  ///< That libfreenect sees.
  std::vector<DepthVideoDevice> video_devices;
  std::vector<KeptCalibration> calibrations;  ///< The newest of each device.
  Result<std::string> import_weakness;        ///< Empty: all of the import process's limits hold.
};

Result<std::string> find_opengl_device() {
  MOR_TRY(const auto renderer, OverlayRenderer::create({}));
  return renderer->device();
}

Findings look_around() {
  Findings findings{list_compute_devices(),
                    {},
                    find_opengl_device(),
                    list_usb_cameras(),
                    count_freenect_devices(FreenectOptions{}.library),
                    list_depth_video_devices(),
                    CalibrationStore().list(),
                    weakness_of_import()};
  if (const auto chosen = choose_compute_device(findings.opencl_devices, "opencl"); !chosen) {
    findings.opencl_advice = chosen.error().message;
  }
  return findings;
}

std::string age_of(const KeptCalibration& kept) {
  return age_text(std::chrono::system_clock::now() - kept.made_at);
}

bool is_old(const KeptCalibration& kept) {
  return is_old_calibration(std::chrono::system_clock::now() - kept.made_at);
}

/// Of a device that is plugged in.
std::string calibration_of(const Findings& findings, const std::string& device_id) {
  if (device_id.empty()) return "no serial number: name it with device=ID to keep a calibration";
  const auto kept =
      std::ranges::find(findings.calibrations, device_id, &KeptCalibration::device_id);
  if (kept == findings.calibrations.end()) {
    return fmt::format("{} is not calibrated: `morgagni calibrate --help`", device_id);
  }
  return fmt::format("{} is calibrated, {}", device_id, age_of(*kept));
}

std::string calibrations_text(const Findings& findings) {
  std::string text = fmt::format("\nCalibrations ({})\n", CalibrationStore().folder().string());
  for (const auto& kept : findings.calibrations) {
    text += fmt::format("  {}: {}, {}, depth {}{}\n",
                        kept.device_id,
                        kept.calibration.origin,
                        age_of(kept),
                        kept.calibration.depth_correction ? "corrected" : "not corrected",
                        is_old(kept) ? ": check it with `morgagni calibrate check`" : "");
    for (const auto& [name, value] : kept.figures) text += fmt::format("    {}: {}\n", name, value);
  }
  if (findings.calibrations.empty()) {
    text += "  none: the cameras' own words are believed; see `morgagni calibrate --help`\n";
  }
  return text;
}

std::string cameras_text(const Findings& findings) {
  std::string text = "\nRange cameras (--camera)\n";
  for (const auto& camera : findings.cameras) {
    text += fmt::format("  {} ({}){}\n",
                        camera.product,
                        camera.id,
                        camera.camera.empty() ? "" : ": --camera " + camera.camera);
    if (!camera.advice.empty()) text += fmt::format("    {}\n", camera.advice);
    if (camera.camera.empty()) continue;
    text += fmt::format("    {}\n",
                        camera.device_id.empty()
                            ? "its serial number is read when it is opened: what is kept for such "
                              "is listed below"
                            : calibration_of(findings, camera.device_id));
  }
  for (const auto& device : findings.video_devices) {
    text += fmt::format("  {}{}{}\n",
                        device.card.empty() ? device.path : device.card,
                        device.camera.empty() ? "" : ": --camera ",
                        device.camera);
    if (!device.advice.empty()) text += fmt::format("    {}\n", device.advice);
    if (!device.camera.empty()) {
      text += fmt::format("    {}\n", calibration_of(findings, device.device_id));
    }
  }
  if (findings.cameras.empty() && findings.video_devices.empty()) text += "  none is plugged in\n";
  text += "  any other, on this machine or the network: --camera push:8765 (docs/cameras.md)\n";
  text += fmt::format("  libfreenect: {}\n",
                      findings.num_kinects ? fmt::format("{} Kinects", *findings.num_kinects)
                                           : findings.num_kinects.error().message);
  return text + calibrations_text(findings);
}

std::string to_text(const Findings& findings) {
  std::string text = fmt::format("morgagni {}\n\nOpenCL (--device of the icp methods)\n", kVersion);
  for (const auto& device : findings.opencl_devices) {
    text += fmt::format("  {}\n    {}, {} units, {:.1f} GiB{}; driver {}\n",
                        device.name,
                        to_string(device.type),
                        device.num_units,
                        static_cast<double>(device.memory_bytes) / (1U << 30U),
                        device.has_double ? "" : ", no double precision",
                        device.platform);
  }
  if (!findings.opencl_advice.empty()) text += fmt::format("  {}\n", findings.opencl_advice);
  text += fmt::format(
      "\nOpenGL (the live picture)\n  {}\n",
      findings.opengl_device ? *findings.opengl_device : findings.opengl_device.error().message);
  const auto& weakness = findings.import_weakness;
  text += fmt::format("\nReading CTs that nobody vouches for\n  {}\n",
                      !weakness           ? weakness.error().message
                      : weakness->empty() ? "all limits of the import process hold"
                                          : *weakness);
  return text + cameras_text(findings);
}

std::string to_json(const Findings& findings) {
  auto devices = nlohmann::ordered_json::array();
  for (const auto& device : findings.opencl_devices) {
    devices.push_back({{"name", device.name},
                       {"driver", device.platform},
                       {"type", to_string(device.type)},
                       {"units", device.num_units},
                       {"memory_bytes", device.memory_bytes},
                       {"double_precision", device.has_double}});
  }
  auto cameras = nlohmann::ordered_json::array();
  for (const auto& camera : findings.cameras) {
    cameras.push_back({{"product", camera.product},
                       {"usb", camera.id},
                       {"camera", camera.camera},
                       {"allowed", camera.is_allowed},
                       {"advice", camera.advice}});
  }
  auto video_devices = nlohmann::ordered_json::array();
  for (const auto& device : findings.video_devices) {
    video_devices.push_back({{"path", device.path},
                             {"card", device.card},
                             {"camera", device.camera},
                             {"device_id", device.device_id},
                             {"advice", device.advice}});
  }
  auto calibrations = nlohmann::ordered_json::array();
  for (const auto& kept : findings.calibrations) {
    calibrations.push_back({{"device_id", kept.device_id},
                            {"origin", kept.calibration.origin},
                            {"age", age_of(kept)},
                            {"depth_corrected", kept.calibration.depth_correction != nullptr},
                            {"old", is_old(kept)}});
  }
  const auto& opengl = findings.opengl_device;
  const auto& kinects = findings.num_kinects;
  const auto& weakness = findings.import_weakness;
  const nlohmann::ordered_json json = {
      {"version", kVersion},
      {"opencl_devices", devices},
      {"opengl_device", opengl ? nlohmann::ordered_json(*opengl) : nlohmann::ordered_json()},
      {"import_weakness", weakness ? *weakness : weakness.error().message},
      {"range_cameras", cameras},
      {"depth_video_devices", video_devices},
      {"calibrations", calibrations},
      {"kinects", kinects ? nlohmann::ordered_json(*kinects) : nlohmann::ordered_json()}};
  return json.dump(2) + "\n";
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  auto as_json = std::make_shared<bool>(false);
  auto* command = app.add_subcommand(
      "doctor",
      "List what this machine offers: OpenCL devices, the OpenGL renderer, range cameras");
  command->add_flag("--json", *as_json, "As JSON");
  command->footer(
      "Examples:\n"
      "  morgagni doctor\n"
      "  morgagni serve --case cases/0815 --method trimmed-icp --device opencl\n"
      "  morgagni serve --case cases/0815 --method trimmed-icp --device geforce");
  command->callback([as_json] {
    const Findings findings = look_around();
    fmt::print("{}", *as_json ? to_json(findings) : to_text(findings));
  });
}

}  // namespace mor
