// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/image.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor::internal {

struct AtlasPicture {
  Image<Rgb8> picture;
  double seen_share = 0.0;  ///< Of the texels of the skin; the atlas has about one scale.
};

/// The texture as others may show it: what was never seen is kNeverSeenColor, and each patch's
/// colours go on over its rim, so that a viewer's filtering does not mix in what lies between the
/// patches.
[[nodiscard]] AtlasPicture paint_atlas(const SkinTexture& texture);

}  // namespace mor::internal
