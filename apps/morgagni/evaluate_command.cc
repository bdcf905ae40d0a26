// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "commands.h"
#include "evaluate/commands.h"

namespace mor {

void add_evaluate_command(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Measure accuracy and time against known truth");
  command->require_subcommand(1);
  add_evaluate_bound_command(*command);
  add_evaluate_recording_command(*command);
  add_evaluate_self_calibration_command(*command);
  add_evaluate_starts_command(*command);
  add_evaluate_studies_command(*command);
  add_evaluate_texture_command(*command);
}

}  // namespace mor
