// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/result.h"

#include "messages.h"

namespace mor::import {

/// A closed polygon in space, LPS mm; three points or more.
using Contour = std::vector<Eigen::Vector3d>;

/// Parallel contours as planes of a grid.
struct ContourStack {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Of the grid, LPS; z across the planes.
  struct Plane {
    double height_mm = 0.0;                              ///< Along axes' z.
    std::vector<std::vector<Eigen::Vector2d>> polygons;  ///< Along axes' x and y.
  };
  std::vector<Plane> planes;  ///< In order.
};

/// @errors kInvalidArgument: a contour is not flat, or they are not parallel.
[[nodiscard]] Result<ContourStack> stack_of(const std::vector<Contour>& contours,
                                            const std::string& name);

/// The grid that holds a stack with a voxel of air around it. @errors kInvalidArgument: too large.
[[nodiscard]] Result<ImportHeader> grid_of(const ContourStack& stack, const std::string& name);

/// Sets the voxels inside of the contours to `label`, by the even-odd rule; each slice is of the
/// nearest plane.
void fill(const ContourStack& stack,
          const ImportHeader& grid,
          std::int16_t label,
          std::span<std::int16_t> voxels);

}  // namespace mor::import
