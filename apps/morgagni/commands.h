// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace CLI {
class App;
}

namespace mor {

/// Each adds its subcommand to the program: options, examples, and what to do, which ends by
/// throwing CLI::RuntimeError with the exit code when it fails.
void add_prepare_command(CLI::App& app);
void add_serve_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_self_calibrate_command(CLI::App& app);
void add_evaluate_command(CLI::App& app);
void add_document_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_pacs_command(CLI::App& app);

}  // namespace mor
