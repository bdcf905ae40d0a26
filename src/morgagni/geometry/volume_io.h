// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"
#include "morgagni/geometry/volume.h"

namespace mor {

/// The case's own form of a CT: voxels without loss, each slice packed by itself so that all cores
/// unpack them. @errors kIo; kInvalidArgument: not a voxel.
[[nodiscard]] Result<void> write_volume(const std::filesystem::path& path, const Volume& volume);

/// @errors kNotFound, kIo; kInvalidArgument: not such a file, damaged, or larger than a CT.
/// @cost About 0.3 s for a chest's 16 million voxels on two cores.
[[nodiscard]] Result<Volume> read_volume(const std::filesystem::path& path);

}  // namespace mor
