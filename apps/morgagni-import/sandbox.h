// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "morgagni/core/result.h"

namespace mor::import {

/// Gives up everything that reading a file does not need, for good: more than 300 s of processor
/// time, more than 256 MiB until a size is declared, writing or making files, opening other files
/// than those of the job, the network, other programs. What a hostile file makes of this process
/// stays within it. Where other files cannot be closed (an old kernel) that is said.
/// @errors kUnsupported: system calls cannot be given up, so that nothing may be read.
[[nodiscard]] Result<void> give_up_rights(const std::filesystem::path& to_read);

/// Raises the memory limit to 256 MiB and what a file has declared, once that was found plausible.
void allow_memory(std::uint64_t declared_bytes);

/// The memory file for the parent takes its part of what was allowed, and grows no further.
void spend_on_hand_over(std::uint64_t num_bytes);

/// Lowers the processor time for everything to 5 s and what goes with a file of that length: past
/// it the process dies (SIGXCPU).
void limit_time_for(std::uint64_t file_bytes);

}  // namespace mor::import
