// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/alignment_input.h"

#include <cmath>
#include <vector>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr double kRotationTolerance = 1e-6;

/// Finite only when all of them are: one test instead of one a point.
float sum_of_coordinates(const std::vector<Eigen::Vector3f>& vectors) {
  if (vectors.empty()) return 0.0F;
  return Eigen::Map<const Eigen::VectorXf>(vectors.front().data(),
                                           3 * static_cast<Eigen::Index>(vectors.size()))
      .sum();
}

}  // namespace

Result<void> check_alignment_input(const PointCloud& moving,
                                   const Eigen::Isometry3d& fixed_from_moving_init,
                                   bool needs_normals) {
  const Eigen::Matrix3d rotation = fixed_from_moving_init.linear();
  if (!fixed_from_moving_init.matrix().allFinite() ||
      !(rotation.transpose() * rotation).isIdentity(kRotationTolerance) ||
      rotation.determinant() < 0.0) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the start pose of a registration must be finite, a rotation and a shift");
  }
  if (needs_normals && moving.normals.size() != moving.points.size()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the moving surface needs a normal for each of its {} points, got {}",
                    moving.points.size(),
                    moving.normals.size()));
  }
  if (!std::isfinite(sum_of_coordinates(moving.points) + sum_of_coordinates(moving.normals))) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the moving surface holds a point or normal that is not finite");
  }
  return {};
}

}  // namespace mor::internal
