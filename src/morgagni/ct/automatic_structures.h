// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/label_map.h"
#include "morgagni/geometry/volume.h"

namespace mor {

struct AutomaticStructureOptions {
  double gas_hu = -400.0;  ///< Lungs and gas are at or below this.
  double lung_min_mean_hu =
      -930;  ///< On average lungs are above it (they hold tissue), gas is not.
  double min_lung_ml = 100.0;
  double min_gas_ml = 0.2;     ///< Smaller pockets are noise.
  double metal_hu = 2800.0;    ///< Metal is at or above this, enamel and bone are below.
  double min_metal_mm3 = 3.0;  ///< Smaller specks are noise.
  int num_triangles = 20000;   ///< Of each structure, at most about.

  [[nodiscard]] Result<void> check() const;
};

/// What a CT shows without a model and without a human: "lungs" (with the airways that hang on
/// them), "gas" (bowel, sinuses, wound channels, putrefaction) and "metal" (projectiles, implants,
/// fillings); those that are there, in this order. By thresholds: whoever reads them has to look.
///
/// @param body  SkinSurfaces::body: beside the body kOutsideHu.
/// @return Closed, smooth meshes with normals, frame ct; a cut by the scan's end is closed flat.
/// @errors kInvalidArgument: bad options.
[[nodiscard]] Result<std::vector<StructureSurface>> extract_automatic_structures(
    const Volume& body, const AutomaticStructureOptions& options, const Progress& progress);

}  // namespace mor
