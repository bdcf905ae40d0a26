// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <stop_token>
#include <string>

#include "morgagni/core/result.h"
#include "morgagni/pacs/internal/dimse_talk.h"

namespace mor::internal {

/// `morgagni-dimse` beside the running program, or in the folder `bin` beside that folder.
/// @errors kNotFound.
[[nodiscard]] Result<std::filesystem::path> find_dimse_program();

/// What one child is to do.
struct DimseJob {
  std::string task;    ///< JSON.
  int socket_fd = -1;  ///< Handed to it; stays the caller's.
  std::string peer;    ///< For sentences.
  std::chrono::seconds time_limit{24 * 3600};
};

/// Runs `program` to its end; it is killed at `stop`, at the time limit, and when it says what it
/// should not. Events come on this thread.
/// @return How many sub-operations the peer calls failed. @errors What the child says; kIo when it
/// dies; kTimeout; kCancelled.
[[nodiscard]] Result<int> run_dimse_process(const std::filesystem::path& program,
                                            const DimseJob& job,
                                            const DimseEvents& events,
                                            std::stop_token stop);

}  // namespace mor::internal
