// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "morgagni/core/result.h"

namespace mor::import {

/// Whether there is a DICOM RT Structure Set among the files.
[[nodiscard]] bool holds_structure_set(const std::filesystem::path& path);

/// Hands one structure of an RT Structure Set to the parent as a label map: its closed contours
/// filled on a grid of their own, which has their planes as slices. Contours within contours are
/// holes. Structures may overlap, so that each has a map of its own; how many there are is told.
/// @param wanted  Which: "1" to their number; empty: the first.
/// @errors kIo (damaged), kUnsupported: no closed contour in any structure; kInvalidArgument: no
/// such
///         structure, contours that are not flat, or not parallel, or too large.
[[nodiscard]] Result<void> import_dicom_structures(const std::filesystem::path& path,
                                                   const std::string& wanted);

}  // namespace mor::import
