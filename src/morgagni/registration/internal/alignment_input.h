// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/geometry/point_cloud.h"

namespace mor::internal {

/// What every method asks of its input. @errors kInvalidArgument: a number that is not finite, a
/// start that is no rigid motion, normals missing where `needs_normals`.
[[nodiscard]] Result<void> check_alignment_input(const PointCloud& moving,
                                                 const Eigen::Isometry3d& fixed_from_moving_init,
                                                 bool needs_normals);

}  // namespace mor::internal
