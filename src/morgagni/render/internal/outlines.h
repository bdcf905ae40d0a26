// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/render/internal/composition.h"
#include "morgagni/render/internal/layer.h"
#include "morgagni/render/internal/occluders.h"
#include "morgagni/render/internal/picture_rays.h"
#include "morgagni/render/internal/view_grid.h"

namespace mor::internal {

/// A structure by itself, opaque, over the whole picture.
struct OutlinedStructure {
  Layer layer;
  Eigen::Vector3f color;
};

/// What stands between the camera and a structure.
struct OutlineScene {
  const HoleMask* mask = nullptr;
  std::span<const Layer> layers = {};  ///< What is drawn in the hole, the structures among it.
  const Layer* volume = nullptr;       ///< The hole with the volume in it. Null: there is none.
  const PictureRays* rays = nullptr;
  const ViewGrid* grid = nullptr;
  const Occluders* occluders = nullptr;  ///< Of the whole picture. Null: nothing is in front.
};

/// Draws, as thin lines in the structures' colours, the outlines that are not seen: those behind
/// something else in the hole, and those outside of it, under the skin. What is seen keeps its
/// look.
void draw_hidden_outlines(std::span<const OutlinedStructure> structures,
                          const OutlineScene& scene,
                          ImageView<Rgba8> picture);

}  // namespace mor::internal
