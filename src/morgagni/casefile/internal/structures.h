// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/casefile/prepare.h"

namespace mor::internal {

inline constexpr std::size_t kMaxStructures = 200;  ///< Of a case, with the bone.

/// Beside the bone: those that were found and those of files, each name once.
/// @errors kInvalidArgument: a file lies elsewhere in space than the CT; too many. As the readers.
[[nodiscard]] Result<std::vector<StructureSurface>> all_structures(
    const Volume& volume,
    std::vector<StructureSurface> found,
    const PrepareOptions& options,
    const Progress& progress);

}  // namespace mor::internal
