// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"

#include "messages.h"

namespace mor::import {

/// Reads the one CT series of a folder (and its sub-folders). Files that are no CT slice are passed
/// over with a note. Tilted and unevenly spaced slices are resampled onto a right-angled grid.
/// @errors As import_volume(); kUnsupported names the series when there are several.
[[nodiscard]] Result<ImportedVolume> read_dicom_folder(const std::filesystem::path& folder);

}  // namespace mor::import
