// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor {

/// Largest side of a picture that is read; a larger one is refused before anything is allocated.
inline constexpr int kMaxPngSidePx = 16384;

/// Reads an 8-bit RGB (or grey, palette, RGBA: converted) PNG.
/// @errors kNotFound, kIo (not a PNG, truncated), kInvalidArgument (larger than kMaxPngSidePx).
[[nodiscard]] Result<Image<Rgb8>> read_png_rgb(const std::filesystem::path& path);

/// Reads a 16-bit grey PNG, as depth images are stored. Anything else is refused.
[[nodiscard]] Result<Image<std::uint16_t>> read_png_gray16(const std::filesystem::path& path);

/// The same from memory. @errors As above; the sentence names no file.
[[nodiscard]] Result<Image<Rgb8>> decode_png_rgb(std::span<const std::byte> bytes);
[[nodiscard]] Result<Image<std::uint16_t>> decode_png_gray16(std::span<const std::byte> bytes);

/// What a PNG says of itself at its start.
struct PngHead {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  bool is_gray16 = false;
};

/// Reads the head alone: whoever has a stranger's picture looks at its size before it is unpacked.
/// @errors kIo: not a PNG.
[[nodiscard]] Result<PngHead> read_png_head(std::span<const std::byte> bytes);

/// PNG bytes, quick compression.
[[nodiscard]] std::vector<std::byte> encode_png(ImageView<const Rgb8> image);
[[nodiscard]] std::vector<std::byte> encode_png(ImageView<const Rgba8> image);
[[nodiscard]] std::vector<std::byte> encode_png(ImageView<const std::uint16_t> image);

}  // namespace mor
