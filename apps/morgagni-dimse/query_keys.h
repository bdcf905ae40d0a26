// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/result.h"

#include "task.h"

class DcmDataset;

namespace mor::dimse {

/// The task's level and keys as the dataset of a C-FIND, C-GET or C-MOVE.
[[nodiscard]] Result<void> put_keys(const Task& task, DcmDataset& dataset);

}  // namespace mor::dimse
