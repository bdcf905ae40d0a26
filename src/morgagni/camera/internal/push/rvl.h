// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "morgagni/core/result.h"

namespace mor::internal {

/// Unpacks a depth picture in RVL (Wilson, Fast Lossless Depth Image Compression, ISS 2017), as
/// ROS's compressedDepth has it: runs of zeros and of differences, in groups of three bits, eight
/// to a little-endian word of 32 bits.
/// @param pixels  Whose number is what must come out.
/// @errors kInvalidArgument: the bytes end too early, or a run leaves the picture.
[[nodiscard]] Result<void> decode_rvl(std::span<const std::byte> packed,
                                      std::span<std::uint16_t> pixels);

}  // namespace mor::internal
