// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "commands.h"
#include "pacs/pacs_commands.h"

namespace mor {

void add_pacs_command(CLI::App& app) {
  auto* command = app.add_subcommand("pacs", "CTs from a hospital's PACS: look, fetch, receive");
  command->require_subcommand(1);
  command->footer(
      "Examples:\n"
      "  morgagni pacs query https://pacs.example/dicom-web --patient-id 0815\n"
      "  morgagni pacs get dicom://PACS@pacs.example:104 --patient-id 0815 --out ct/0815\n"
      "  morgagni pacs serve --cases cases --listen 0.0.0.0 --accept PACS\n"
      "docs/pacs.md says what the PACS has to know of this computer.");
  add_pacs_query_command(*command);
  add_pacs_get_command(*command);
  add_pacs_serve_command(*command);
}

}  // namespace mor
