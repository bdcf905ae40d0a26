// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace mor::import {

/// Leaves this process, for good, no files to open but those it was started for: the file, or the
/// folder with what its links name; beside heads that name other files (.mhd, .nhdr, DICOMDIR)
/// their folder. A kernel without Landlock (before 5.13) leaves everything readable.
void see_only(const std::filesystem::path& path);

}  // namespace mor::import
