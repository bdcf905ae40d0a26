// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/result.h"

#include "task.h"

namespace mor::dimse {

/// Gives up what a DICOM connection does not need: memory beyond 512 MiB, files much beyond the
/// task's `max_object_bytes`, other files than the task's folders and TLS files and those that
/// finding a host takes, other programs, other processes. Ends with the parent. Where other files
/// cannot be closed (an old kernel) that is said.
/// @errors kUnsupported: system calls cannot be given up, so that nobody may be talked to.
[[nodiscard]] Result<void> confine(const Task& task);

}  // namespace mor::dimse
