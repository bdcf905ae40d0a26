// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"

namespace mor::import {

/// Hands a DICOM Segmentation (binary or fractional, pixels not compressed) to the parent as a
/// label map: each frame goes where it says it lies, with its segment's number as label; names and
/// colours (CIELab) come with it. Where segments overlap the later one counts, which is noted.
/// @param path  A file, or a folder or archive with one segmentation in it.
/// @errors kUnsupported: no segmentation or several, another type, compressed pixels. kIo: cut
/// short. kInvalidArgument: frames that are not parallel, not evenly apart, tilted, or too many.
[[nodiscard]] Result<void> import_dicom_segmentation(const std::filesystem::path& path);

}  // namespace mor::import
