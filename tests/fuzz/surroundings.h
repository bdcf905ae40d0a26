// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

/// What the readers meet in a fuzz target instead of the import process: no limits on memory and
/// time (libFuzzer has its own), messages to nowhere, and what was read in memory whose ends the
/// address sanitizer watches.
namespace mor::fuzz {

/// A folder in memory of this process alone; removed when the process ends well.
[[nodiscard]] const std::filesystem::path& scratch_folder();

/// Writes a file into the scratch folder, over what was there.
std::filesystem::path write(std::string_view name, std::span<const std::byte> bytes);

/// What the readers handed over is believed as little as the parent believes it, then given back.
/// Ends the process where it is not what its own header says.
void take_over();

}  // namespace mor::fuzz
