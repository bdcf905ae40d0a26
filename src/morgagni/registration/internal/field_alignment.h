// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/internal/normal_equations.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {

/// Which of the moving points are looked at.
enum class PointShare : std::uint8_t {
  kFew,   ///< Spread over all.
  kRuns,  ///< Runs of neighbours, for the look at rows.
  kAll,
};

/// One stage of the annealing: a kernel, the field and the points it is used with.
struct Stage {
  PairingRule rule;
  bool fine = false;  ///< The field's level.
  PointShare points = PointShare::kFew;
  int max_iterations = 1;
  double stop_step_mm = 0.1;  ///< Converged when a step moves the points by less.
};

/// How far a pose is expected to be off, as standard deviations.
struct PoseSpread {
  double shift_mm = 0.0;
  double rotation_rad = 0.0;  ///< About the middle of the moving points.
};

/// How well a pose agrees with what the camera sees.
struct PoseFit {
  /// Of the points' weight, within 5 mm of skin that faces the camera.
  double near_fraction = 0.0;
  double below_fraction = 0.0;  ///< Of the points, farther than that below it: seen through it.
  double pair_fraction = 0.0;   ///< Of the points' weight, what the kernel leaves of it.

  [[nodiscard]] double score() const { return pair_fraction - below_fraction; }
  /// 0 where nothing is near.
  [[nodiscard]] double share_of_near() const {
    return near_fraction > 0.0 ? pair_fraction / near_fraction : 0.0;
  }
  /// For choosing among poses. Much clutter that lies about where skin should be is no match for
  /// less skin that readings follow, so what is near counts by how well it follows.
  [[nodiscard]] double evidence() const { return score() * share_of_near(); }
};

/// The working state of one registration on a field: a pose that Gauss-Newton steps improve, held
/// by the start in the directions that the data leaves open.
class FieldAlignment {
 public:
  FieldAlignment(const DistanceField& field,
                 const PointCloud& moving,
                 const Eigen::Isometry3d& start,
                 const PoseSpread& start_spread);

  [[nodiscard]] const Eigen::Isometry3d& pose() const { return pose_; }
  void set_pose(const Eigen::Isometry3d& pose) { pose_ = pose; }
  /// Of the moving points, where the pose puts them.
  [[nodiscard]] Eigen::Vector3d pivot() const { return pose_ * center_; }

  /// How far apart the pose and another one put the moving points, about.
  [[nodiscard]] double distance_mm(const Eigen::Isometry3d& other) const;

  /// Runs one stage; false when too few points find the surface.
  [[nodiscard]] bool run(const Stage& stage, int max_iterations);
  /// Runs stage after stage; false when one finds too few points.
  [[nodiscard]] bool run_all(std::span<const Stage> stages, int max_iterations);
  /// Looks at the pose as a stage would, without a step.
  [[nodiscard]] PoseFit fit(const Stage& stage);
  /// What the last look of all told: after a stage how its last step found the pose.
  [[nodiscard]] const PoseFit& last_fit() const { return last_fit_; }
  /// The result at the pose as it is, by all points.
  [[nodiscard]] RegistrationResult finish(const PairingRule& rule);

 private:
  [[nodiscard]] const SensorPoints& points_of(PointShare share) const;
  [[nodiscard]] NormalEquations look(const Stage& stage);
  [[nodiscard]] double step(const NormalEquations& equations, double stride);
  [[nodiscard]] Vector6d start_information() const;
  [[nodiscard]] std::vector<OpenDirection> open_directions(const NormalEquations& equations) const;
  /// Of the points that the last look paired.
  [[nodiscard]] bool has_shape() const;

  const DistanceField& field_;
  std::size_t num_moving_;
  SensorPoints few_;
  SensorPoints runs_;
  SensorPoints all_;
  Eigen::Isometry3d start_;
  PoseSpread spread_;
  Eigen::Isometry3d pose_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();  ///< Of the moving points.
  double radius_mm_ = 1.0;                            ///< Root mean square distance from it.
  Linearizer linearizer_;
  PoseFit last_fit_;
  bool converged_ = false;
  int num_iterations_ = 0;
};

}  // namespace mor::internal
