// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace mor::import {

/// A grey JPEG (ISO 10918-1, lossy or lossless) without its comments and application segments, its
/// head checked: GDCM's decoders end the process over a head that they would have to warn of, and
/// follow a null pointer where it announces more than 16 bits.
/// @return Nothing where it is not one of this size.
[[nodiscard]] std::optional<std::vector<std::byte>> checked_jpeg(std::span<const std::byte> stream,
                                                                 int columns,
                                                                 int rows);

}  // namespace mor::import
