// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/camera/internal/push/messages.h"
#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor::internal::push {

/// Whether it is a depth picture, by its encoding or, of a PNG, by its 16 bits of grey.
[[nodiscard]] bool is_depth(const Picture& picture);

struct PictureSize {
  int width_px = 0;
  int height_px = 0;
};

/// Unpacks a depth picture: 16UC1 (mm) or 32FC1 (m), as they are, in zstd (zstd_image_transport),
/// in PNG, or in PNG or RVL behind the 12 bytes of compressedDepth (16UC1, or 32FC1 by inverse).
/// What is no reading (not finite, not positive, beyond 65.5 m) becomes 0.
/// @param size  What it must have: nothing is unpacked before it is known that it has.
/// @errors kInvalidArgument, kIo: another size, coding or length; damaged.
[[nodiscard]] Result<Image<std::uint16_t>> decode_depth_picture(const Picture& picture,
                                                                PictureSize size);

/// Unpacks a colour picture: rgb8, bgr8, rgba8, bgra8 or mono8, as they are or in zstd; JPEG; PNG.
/// @param size, @errors  As decode_depth_picture().
[[nodiscard]] Result<Image<Rgb8>> decode_color_picture(const Picture& picture, PictureSize size);

}  // namespace mor::internal::push
