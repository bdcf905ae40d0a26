// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "morgagni/core/result.h"

namespace mor::import {

/// Reads a CT series of a folder tree, DICOMDIR, zip archive or multi-frame file and hands it over.
/// Tilted and unevenly spaced slices are resampled onto a right-angled grid.
/// @param series  As choose_series().
/// @errors As import_volume().
[[nodiscard]] Result<void> import_dicom(const std::filesystem::path& path,
                                        const std::string& series);

/// Tells the parent which CT series there are (import_protocol.h). @errors As find_series().
[[nodiscard]] Result<void> list_dicom_series(const std::filesystem::path& path);

}  // namespace mor::import
