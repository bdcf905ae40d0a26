// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "morgagni/core/result.h"

namespace mor {

/// A file, or a folder with all below it, that a process may go on to open.
struct OpenPath {
  std::filesystem::path path;
  bool may_change = false;  ///< Not only read, but write; in a folder make, rename and remove too.
};

/// Leaves this process, for good, no files to open or change but these (Landlock). What is open
/// already stays open; a path that does not exist is passed over.
/// @errors kUnsupported: the kernel has no Landlock (before 5.13), or none that lets files move
/// between folders where something may be changed (before 5.19); everything stays as it was.
[[nodiscard]] Result<void> open_only(const std::vector<OpenPath>& paths);

}  // namespace mor
