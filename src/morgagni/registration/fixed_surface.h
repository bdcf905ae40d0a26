// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/registration/distance_field.h"

namespace mor {

/// The CT skin as registration needs it. Frame ct, LPS mm. Never changes after preparation.
struct FixedSurface {
  TriangleMesh mesh;  ///< With normals, pointing out of the body.
  DistanceField field;
};

}  // namespace mor
