// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace CLI {
class App;
}

namespace mor {

/// The subcommands of `morgagni pacs`.
void add_pacs_query_command(CLI::App& pacs);
void add_pacs_get_command(CLI::App& pacs);
void add_pacs_serve_command(CLI::App& pacs);

}  // namespace mor
