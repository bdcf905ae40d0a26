// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "options.h"

#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "exit.h"

namespace mor {
namespace {

constexpr const char* kMethodNames =
    "field, icp, trimmed-icp, anisotropic-icp or trimmed-anisotropic-icp";

Result<RegistrationMethod> method_option(const std::string& name) {
  if (const auto method = parse_registration_method(name)) return *method;
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("--method must be {}, got \"{}\"", kMethodNames, name));
}

}  // namespace

void add_depth_options(CLI::App& command, BodySurfaceOptions& options) {
  command.add_option("--near-mm", options.near_mm, "Depth: nearer readings are dropped")
      ->capture_default_str();
  command.add_option("--far-mm", options.far_mm, "Depth: farther readings are dropped")
      ->capture_default_str();
  command
      .add_option(
          "--max-edge-mm", options.max_edge_mm, "Depth: neighbours farther apart are not connected")
      ->capture_default_str();
  command
      .add_option("--down-sampling", options.down_sampling, "Depth: every so many pixels, 1 to 4")
      ->capture_default_str();
  command.add_flag("!--single-readings",
                   options.averages,
                   "Depth: do not average the pixels between, as the paper does");
}

void add_registration_options(CLI::App& command, RegistrationOptions& options) {
  command
      .add_option_function<std::string>(
          "--method",
          [&options](const std::string& name) {
            options.method = value_or_exit(method_option(name));
          },
          fmt::format("Registration: {}", kMethodNames))
      ->default_str(std::string(to_string(options.method)));
  command
      .add_option(
          "--device",
          options.device,
          "Where the icp methods run: cpu, opencl (its first device) or a part of an OpenCL "
          "device's name; `morgagni doctor` lists them")
      ->capture_default_str();
}

Result<SimulatedCameraOptions> simulated_camera_option(const std::string& name) {
  constexpr std::string_view kKind = "simulated:";
  if (!name.starts_with(kKind)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("--camera must be simulated:[key=value,...], whose truth is known, got \"{}\"",
                    name));
  }
  return SimulatedCameraOptions::parse(std::string_view(name).substr(kKind.size()));
}

std::filesystem::path default_web_root() {
  std::error_code status;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", status);
  return program.parent_path() / ".." / "web";
}

Result<BodySide> side_option(const std::string& name) {
  if (const auto side = parse_body_side(name)) return *side;
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("--start-side must be anterior, posterior, left or right, got \"{}\"", name));
}

}  // namespace mor
