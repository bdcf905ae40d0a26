// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/alignment_input.h"

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr double kRotationTolerance = 1e-6;

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
  // A sum is finite only when all of its terms are: one test instead of one a point.
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& point : moving.points) sum += point;
  for (const auto& normal : moving.normals) sum += normal;
  if (!sum.allFinite()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the moving surface holds a point or normal that is not finite");
  }
  return {};
}

}  // namespace mor::internal
