// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/pacs/internal/tag_values.h"

namespace mor::internal {

/// The objects of a QIDO-RS answer (DICOM PS3.18, annex F): texts and numbers of their first level,
/// of a person's name the alphabetic form. What is nested deeper is skipped.
/// @errors kIo: not JSON, not a list of objects, nested more than 32 deep.
[[nodiscard]] Result<std::vector<TagValues>> parse_dicom_json(std::string_view text);

}  // namespace mor::internal
