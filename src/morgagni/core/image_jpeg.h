// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor {

/// Largest side of a JPEG that is read; a larger one is refused before anything is allocated.
inline constexpr int kMaxJpegSidePx = 16384;

/// JPEG bytes, baseline, colour at half resolution (4:2:0).
/// @param quality  1..100.
/// @errors kInvalidArgument: an empty picture, a quality outside 1..100.
[[nodiscard]] Result<std::vector<std::byte>> encode_jpeg(ImageView<const Rgb8> image, int quality);

struct JpegSize {
  int width_px = 0;
  int height_px = 0;
};

/// Reads the head alone: whoever has a stranger's picture looks at its size before it is unpacked.
/// @errors kIo: not a JPEG.
[[nodiscard]] Result<JpegSize> read_jpeg_size(std::span<const std::byte> bytes);

/// @errors kIo (not a JPEG, truncated, more scans than any camera makes), kInvalidArgument (larger
/// than kMaxJpegSidePx).
[[nodiscard]] Result<Image<Rgb8>> decode_jpeg(std::span<const std::byte> bytes);

}  // namespace mor
