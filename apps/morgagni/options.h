// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/depth/body_surface.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/start.h"

namespace mor {

/// --near-mm, --far-mm, --max-edge-mm, --down-sampling.
void add_depth_options(CLI::App& command, BodySurfaceOptions& options);

/// --method, --device. Another word than the known methods ends the program with a sentence.
void add_registration_options(CLI::App& command, RegistrationOptions& options);

/// @errors kInvalidArgument: another word than the known ones.
/// What `--camera simulated:key=value,...` says, for commands that need the simulation's truth.
[[nodiscard]] Result<SimulatedCameraOptions> simulated_camera_option(const std::string& name);

/// The page as built: beside the program in the build tree.
[[nodiscard]] std::filesystem::path default_web_root();

[[nodiscard]] Result<BodySide> side_option(const std::string& name);

}  // namespace mor
