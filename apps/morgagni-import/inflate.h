// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "morgagni/core/result.h"

namespace mor::import {

/// How many bytes `compressed` ones may become: CTs shrink to a third, an empty slice to a few
/// hundredths. What claims more is a bomb.
[[nodiscard]] std::uint64_t max_inflated_bytes(std::uint64_t compressed);

/// Inflates a deflate stream without a head. @errors kIo (damaged), kInvalidArgument (a bomb).
[[nodiscard]] Result<std::vector<std::byte>> inflate_raw(std::span<const std::byte> compressed);

}  // namespace mor::import
