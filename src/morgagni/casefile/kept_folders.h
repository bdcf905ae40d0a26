// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>

#include "morgagni/core/result.h"

namespace mor {

/// What people make with a case, as folders of it. Preparing the case anew keeps them.
inline constexpr std::array<const char*, 6> kKeptFolders{
    "findings", "texture", "pictures", "videos", "recordings", "documents"};

/// Whether people made anything in this case, or added a CT to it: on its first CT, of its body.
[[nodiscard]] bool has_kept_files(const std::filesystem::path& case_folder);

/// Puts the kept folders of one case, and the CTs that were added to it, into another, file by
/// file, without taking them from the first: as hard links where the file system has them, else as
/// copies. Links stay links.
/// @errors kIo: which file, and why.
[[nodiscard]] Result<void> carry_over_kept_folders(const std::filesystem::path& from_case,
                                                   const std::filesystem::path& to_case);

}  // namespace mor
