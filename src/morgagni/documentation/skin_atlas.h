// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include "morgagni/core/result.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor {

struct SkinAtlasOptions {
  double px_per_mm = 1.0;  ///< Of skin. [0.1, 8].
  int gutter_px = 4;       ///< Between charts and to the picture's edge. 0..64.
  /// How far a triangle may lean out of its chart's plane while charts grow: its texels are then at
  /// most 1 / cos of that longer than wide. [0.2, 1.2].
  double max_tilt_rad = 40.0 * std::numbers::pi / 180.0;

  [[nodiscard]] Result<void> check() const;
};

/// Unwraps the skin into an atlas: grows charts of triangles that face about the same way, lays
/// each flat on the plane across its mean normal with the head's end up, scales it to its area on
/// the body, and packs the charts. What would overlap within a chart gets one of its own.
///
/// @param skin  With normals; holes, edges of more than two triangles and loose parts are allowed.
///        Triangles without area get a place, and no texels.
/// @errors kInvalidArgument: bad options, no triangles, or a picture above kMaxAtlasSidePx; says
///         how large.
/// @threads Reentrant. The same skin and options give the same atlas.
/// @cost About 0.15 s for 40,000 triangles.
[[nodiscard]] Result<SkinAtlas> unwrap_skin(const TriangleMesh& skin,
                                            const SkinAtlasOptions& options = {});

}  // namespace mor
