// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Places on the upper skin (LPS, supine: up is -y), each as far from the others as can be
/// (farthest point sampling from a seeded first one): where somebody would stick markers. "F01",
/// "F02", ...
/// @param skin  With normals. @errors kInvalidArgument: fewer upward vertices than markers.
[[nodiscard]] Result<std::vector<Target>> sample_skin_targets(const TriangleMesh& skin,
                                                              int num_targets,
                                                              std::uint64_t seed);

/// Places inside the body: a quarter to three quarters of the way from the upper skin straight down
/// to the first skin below. "T01", "T02", ... @errors kInvalidArgument: no such place is found.
[[nodiscard]] Result<std::vector<Target>> sample_internal_targets(const TriangleMesh& skin,
                                                                  int num_targets,
                                                                  std::uint64_t seed);

/// The text of a `targets.csv` that read_targets() reads: name,kind,x_mm,y_mm,z_mm, RAS+.
[[nodiscard]] std::string targets_csv(const std::vector<Target>& targets);

}  // namespace mor
