// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "morgagni/core/result.h"

namespace mor::import {

/// Reads a NIfTI, NRRD or MetaImage file as HU and hands it over. @errors As import_volume().
[[nodiscard]] Result<void> import_image_file(const std::filesystem::path& path);

/// The same for a label map: whole numbers from 0 to 32767, with their names. @errors The same.
[[nodiscard]] Result<void> import_label_file(const std::filesystem::path& path);

}  // namespace mor::import
