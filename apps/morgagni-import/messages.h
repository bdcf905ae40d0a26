// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/ct/import_protocol.h"

namespace mor::import {

/// A volume as it goes to the parent.
struct ImportedVolume {
  ImportHeader header;
  std::vector<std::int16_t> hu;
};

/// The lines of the protocol (morgagni/ct/import_protocol.h). Sent at once, so that they arrive
/// even when the next step crashes.
void say_progress(double fraction);
void say_file(std::string_view name);
void say_note(std::string_view sentence);
void say_error(const Error& error);

void set_description(ImportHeader& header, std::string_view text);

/// Writes header and voxels to the parent's memory file. @errors kIo.
[[nodiscard]] Result<void> hand_over(const ImportedVolume& volume);

}  // namespace mor::import
