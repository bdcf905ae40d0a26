// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The registration author's to shape; FixedSurface, casefile and prepare use only what stands here.

#include <filesystem>

#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

class DistanceField {
 public:
  /// @errors kInvalidArgument: an empty mesh, one without normals.
  /// @cost <= 1.5 s on two cores for a torso.
  [[nodiscard]] static Result<DistanceField> build(const TriangleMesh& mesh);
};

[[nodiscard]] Result<DistanceField> read_distance_field(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_distance_field(const std::filesystem::path& path,
                                                const DistanceField& field);

}  // namespace mor
