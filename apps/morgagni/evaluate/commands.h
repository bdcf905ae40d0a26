// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace CLI {
class App;
}

namespace mor {

/// The studies under `morgagni evaluate`, one file each; each adds its subcommand.
void add_evaluate_bound_command(CLI::App& evaluate_app);
void add_evaluate_recording_command(CLI::App& evaluate_app);
void add_evaluate_self_calibration_command(CLI::App& evaluate_app);
void add_evaluate_starts_command(CLI::App& evaluate_app);
void add_evaluate_studies_command(CLI::App& evaluate_app);
void add_evaluate_texture_command(CLI::App& evaluate_app);

}  // namespace mor
