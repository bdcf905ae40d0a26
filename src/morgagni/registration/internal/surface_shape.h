// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace mor::internal {

/// A seen surface within so many of a reading's standard deviations of a line, plane or sphere is
/// one.
inline constexpr double kShapeNoiseRatio = 1.5;

/// Whether points say where they lie: on a line, a plane or a sphere they can slide along
/// themselves, and no matching of shapes may claim to know their pose.
///
/// @param points  Finite, mm. At least one.
/// @param noise_mm  Standard deviation of the points; a shape within it counts.
/// @return "line", "plane", "sphere", or none: the points have a shape of their own.
[[nodiscard]] std::optional<const char*> shape_without_pose(std::span<const Eigen::Vector3f> points,
                                                            double noise_mm);

/// How much the weakest direction of a pose is held by pairs of points and planes: the smallest
/// eigenvalue of the mean J J^T, rotations measured by how they move the points; 0 (open) to 1/6.
///
/// @param points  Of the pairs, in the frame of the planes. @param normals  Unit, one each.
[[nodiscard]] double weakest_constraint(std::span<const Eigen::Vector3f> points,
                                        std::span<const Eigen::Vector3f> normals);

}  // namespace mor::internal
