// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/image.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/view_grid.h"
#include "morgagni/render/overlay_renderer.h"

namespace mor::internal {

/// The wall of the hole, as if it were bored into the body along the line of sight: it begins at
/// the skin on the rim, runs inwards by perspective, takes the rim's colours and gets darker with
/// depth. What lies nearer covers it, what lies deeper is covered by it: that is what tells the eye
/// how deep it looks.
///
/// @param picture  The live picture: its colours along the rim are those of the wall.
/// @param wall     Of the box that it has; cleared where there is no wall.
void draw_hole_wall(const Hole& hole,
                    ImageView<const Rgba8> picture,
                    const PictureRays& rays,
                    const ViewGrid& grid,
                    Layer& wall);

}  // namespace mor::internal
