// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace mor::dimse {

/// Gives up what a DICOM connection does not need: memory beyond 512 MiB, files much beyond
/// `max_file_bytes`, other programs, other processes. Ends with the parent.
void confine(std::uint64_t max_file_bytes);

}  // namespace mor::dimse
