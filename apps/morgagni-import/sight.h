// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"

namespace mor::import {

/// Leaves this process, for good, no files to open but those it was started for: the file, or the
/// folder with what its links name; beside heads that name other files (.mhd, .nhdr, DICOMDIR)
/// their folder. @errors As open_only().
[[nodiscard]] Result<void> see_only(const std::filesystem::path& path);

}  // namespace mor::import
