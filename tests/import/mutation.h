// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <string>

namespace mor {

/// One to eight changes: bytes flipped, lost, doubled or overwritten, numbers in text made absurd;
/// one in ten is cut short as well.
[[nodiscard]] std::string mutated(std::string bytes, std::mt19937& random);

}  // namespace mor
