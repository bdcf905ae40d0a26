// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/registration/distance_field.h"

namespace mor {

/// The skin as registration needs it: the CT's, or as it was found to be since. Frame ct, LPS mm.
/// Never changes.
struct FixedSurface {
  TriangleMesh mesh;  ///< With normals, pointing out of the body.
  DistanceField field;
  std::string change = {};  ///< How it differs from the CT's, in words. Empty: it is the CT's.
};

}  // namespace mor
