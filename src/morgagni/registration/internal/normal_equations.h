// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/distance_field.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Which pairs of moving point and field count, and how much.
struct PairingRule {
  /// Tukey's scales: a pair farther apart does not count. Points above the skin may be clutter,
  /// points below it cannot be seen through it and so tell of an error of the pose.
  float above_scale_mm = 10.0F;
  float below_scale_mm = 10.0F;
  float min_normal_cosine = 0.5F;  ///< Between the normals of a pair.
  /// Tukey's scale for the mean distance of a point and its neighbours in the picture's row; 0: not
  /// looked at. A sensor's noise differs from point to point and averages out; the edge of a towel
  /// or hand does not, so this scale can be far below the other one.
  float row_scale_mm = 0.0F;
};

/// One linearisation of the weighted squared point-to-plane distances about a pose:
/// sum w (d + J twist)^2 with twist = (rotation about the pivot, shift), frame ct.
struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();  ///< sum w J^T J.
  Vector6d gradient = Vector6d::Zero();     ///< sum w J^T d.
  double sum_weights = 0.0;
  double sum_weighted_sq = 0.0;  ///< sum w d^2.
  int num_pairs = 0;
};

/// Pairs points with the field; keeps its buffers between calls, so one thread at a time.
class Linearizer {
 public:
  /// @param points  In the picture's order where the rule looks at rows.
  /// @param pivot  Of the rotation, frame ct.
  [[nodiscard]] NormalEquations linearize(const FieldLevel& level,
                                          std::span<const SensorPoint> points,
                                          const Eigen::Isometry3d& fixed_from_moving,
                                          const Eigen::Vector3d& pivot,
                                          const PairingRule& rule);

 private:
  /// A moving point in the CT with what the field says there.
  struct Pair {
    Eigen::Vector3f p;
    FieldSample sample;
    float weight = 0.0F;  ///< 0: not a pair.
  };

  void find_pairs(const FieldLevel& level,
                  std::span<const SensorPoint> points,
                  const Eigen::Isometry3f& fixed_from_moving,
                  const PairingRule& rule);
  void weigh_by_rows(std::span<const SensorPoint> points, float scale_mm);

  std::vector<Pair> pairs_;
  std::vector<float> distances_mm_;  ///< Of each point, cut to the rule's scales.
};

}  // namespace mor::internal
