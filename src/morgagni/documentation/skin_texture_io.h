// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "morgagni/core/result.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor {

/// Largest side of an atlas that is written or read: 8 m of skin at 1 px/mm.
inline constexpr int kMaxAtlasSidePx = 8192;
/// Frame indices are kept as 16-bit numbers, 0 for what was never seen.
inline constexpr std::size_t kMaxTextureFrames = 65534;

/// Writes a texture as a folder (docs/fused-texture.md, "On disk"): texture.json, color.png,
/// skin.ply, corners.bin, and the provenance as four 16-bit PNGs. Written aside and put in its
/// place in one step: on failure the old folder stays as it was.
/// @errors kInvalidArgument: sizes that do not fit together, more than kMaxTextureFrames frames, a
///         side above kMaxAtlasSidePx. kIo: no permission, disk full.
[[nodiscard]] Result<void> write_skin_texture(const std::filesystem::path& folder,
                                              const SkinTexture& texture);

/// Reads what write_skin_texture wrote, each file checked against its hash. Angles come back to
/// 0.0001 rad, distances to 0.1 mm, resolutions to 0.001 px/mm; everything else exactly.
/// @errors kNotFound: no such folder, or no texture.json in it. kIo, kInvalidArgument: damaged, too
///         large, or of a newer format; one sentence says what.
[[nodiscard]] Result<SkinTexture> read_skin_texture(const std::filesystem::path& folder);

}  // namespace mor
