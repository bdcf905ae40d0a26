// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mor::import {

/// How a VTK XML file writes its numbers.
struct VtpCoding {
  bool big_endian = false;
  bool wide_heads = false;  ///< Lengths are UInt64, else UInt32.
  bool compressed = false;  ///< With zlib, in blocks.
};

/// The bytes of one array from where it begins.
/// @param at_most  It has no more bytes than this. @return None: damaged, or it claims more.
[[nodiscard]] std::optional<std::vector<std::byte>> vtp_raw(std::span<const std::byte> bytes,
                                                            const VtpCoding& coding,
                                                            std::size_t at_most);
[[nodiscard]] std::optional<std::vector<std::byte>> vtp_base64(std::string_view text,
                                                               const VtpCoding& coding,
                                                               std::size_t at_most);

/// Numbers of a VTK type ("Float32", "Int64", ...). None: no such type, or a number is cut.
[[nodiscard]] std::optional<std::vector<double>> vtp_numbers(std::span<const std::byte> bytes,
                                                             std::string_view type,
                                                             bool big_endian);
/// The same of "1 2.5 3"; a NaN is a number here. None: more than `at_most`, or no number.
[[nodiscard]] std::optional<std::vector<double>> vtp_ascii(std::string_view text,
                                                           std::size_t at_most);
/// Bytes a number of this type takes; 0: no such type.
[[nodiscard]] std::size_t vtp_type_bytes(std::string_view type);

}  // namespace mor::import
