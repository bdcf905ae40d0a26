// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor::internal {

/// So much of a file is enough for part10_uid().
inline constexpr std::size_t kPart10HeadBytes = 4096;

/// The SOP Instance UID that the head of a DICOM file names (PS3.10, "Media Storage SOP Instance
/// UID"). Reads the file meta information only, which has one coding and no sequences.
/// @param head  The file's first bytes. @errors kIo: no DICOM file, or no proper UID.
[[nodiscard]] Result<std::string> part10_uid(std::string_view head);

}  // namespace mor::internal
