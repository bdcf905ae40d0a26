// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace mor {

/// Which file includes which, as "module/file.h". Only our own includes.
using IncludeGraph = std::map<std::string, std::set<std::string>>;

/// The layer of each module (docs/architecture.md).
using Layers = std::map<std::string, int>;

/// Reads the includes of every .h and .cc below `source`.
[[nodiscard]] IncludeGraph read_include_graph(const std::filesystem::path& source);

/// One sentence for each include that goes upward, sideways, into another module's internal/
/// folder, or names an unknown module, and one for each circle of files.
[[nodiscard]] std::vector<std::string> find_violations(const IncludeGraph& graph,
                                                       const Layers& layers);

}  // namespace mor
