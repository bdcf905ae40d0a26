// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace mor::import {

/// Pixels of DICOM's RLE compression (PS3.5, annex G). GDCM's decoder believes what the frame says
/// of itself and writes beyond its memory, so it gets none.
/// @param frame  Its header of 64 bytes and its segments.
/// @return Little endian; nothing where the frame does not hold just these pixels.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_rle(std::span<const std::byte> frame,
                                                               std::size_t num_pixels,
                                                               std::size_t bytes_per_pixel);

}  // namespace mor::import
