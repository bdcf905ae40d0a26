// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/result.h"

#include "task.h"

/// What a task may ask for. Each says its events (messages.h) and returns how many sub-operations
/// the peer reports as failed.
namespace mor::dimse {

[[nodiscard]] Result<int> echo(const Task& task);
[[nodiscard]] Result<int> find(const Task& task);
[[nodiscard]] Result<int> get(const Task& task);
[[nodiscard]] Result<int> move(const Task& task);
/// Serves the association that comes over the socket kSocketFd, to its end.
[[nodiscard]] Result<int> receive(const Task& task);

}  // namespace mor::dimse
