// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace mor::import {

/// Of at least four bytes, the first four.
[[nodiscard]] inline std::uint32_t little_uint32(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
  return value;
}

/// Of at least two bytes, the first two.
[[nodiscard]] inline std::uint16_t big_uint16(std::span<const std::byte> bytes) {
  return static_cast<std::uint16_t>((std::to_integer<unsigned>(bytes[0]) << 8) |
                                    std::to_integer<unsigned>(bytes[1]));
}

}  // namespace mor::import
