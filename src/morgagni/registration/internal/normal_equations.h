// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  /// Tukey's scales for the mean distance of a point and its neighbours in the picture's row, in
  /// standard deviations of a single reading; 0: not looked at. A sensor's noise differs from point
  /// to point and averages out; the edge of a towel or hand does not, so these scales can be far
  /// below the other ones.
  float row_above_scale = 0.0F;
  float row_below_scale = 0.0F;
};

/// One linearisation of the weighted squared point-to-plane distances about a pose:
/// sum w (d + J twist)^2 with twist = (rotation about the pivot, shift), frame ct.
struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();  ///< sum w J^T J.
  Vector6d gradient = Vector6d::Zero();     ///< sum w J^T d.
  double sum_weights = 0.0;
  double sum_weighted_sq = 0.0;  ///< sum w d^2.
  int num_pairs = 0;
  double sum_near_weights = 0.0;  ///< Of points within 5 mm of skin that faces the camera.
  int num_near = 0;               ///< Points within 5 mm of the skin, pairs or not.
  int num_below = 0;              ///< Points farther than that below the skin: seen through it.
};

/// Pairs points with the field; keeps its buffers between calls, so one thread at a time.
class Linearizer {
 public:
  /// @param pivot  Of the rotation, frame ct.
  [[nodiscard]] NormalEquations linearize(const FieldLevel& level,
                                          const SensorPoints& points,
                                          const Eigen::Isometry3d& fixed_from_moving,
                                          const Eigen::Vector3d& pivot,
                                          const PairingRule& rule);

  /// Of the pairs last linearized: the mean square of how far apart the mean distances of two
  /// neighbouring rows of points are, in standard deviations of a single reading. 0 where there are
  /// no two whole rows side by side.
  /// @param points  As given there.
  [[nodiscard]] double mean_sq_between_rows(const SensorPoints& points) const;

  /// Some of the pairs last linearized, spread over all: about `count` moving points, frame ct.
  [[nodiscard]] std::vector<Eigen::Vector3f> some_pairs(std::size_t count) const;

 private:
  /// Moving points in the CT with what the field says there.
  struct PairLanes {
    Lanes x, y, z;
    Lanes normal_x, normal_y, normal_z;  ///< Of the skin; before that, offsets from the nodes.
    Lanes distance_mm;
    Lanes weight;       ///< 0: not a pair.
    Lanes near_weight;  ///< The point's own, where it is near skin that faces the camera.
  };

  void find_pairs(const FieldLevel& level,
                  const SensorPoints& points,
                  const Eigen::Isometry3f& fixed_from_moving,
                  const PairingRule& rule);
  void weigh_by_rows(const SensorPoints& points, const PairingRule& rule);

  std::vector<PairLanes> pairs_;
  std::vector<double> row_sums_mm_;  ///< Of the distances of all points before one.
};

}  // namespace mor::internal
