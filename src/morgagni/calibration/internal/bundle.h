// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/internal/sensor_model.h"

namespace mor::internal {

/// What a fit leaves free beside the poses and the table.
enum class BundleModel : std::uint8_t { kPoses, kSkin, kSensor, kSensorAndSkin };

/// How far a fit may be from its end when it begins.
enum class BundleStart : std::uint8_t { kAnew, kNear };

/// Sensor, skin, table and poses at once.
struct BundleState {
  Eigen::VectorXd values;                        ///< Of the sensor, the skin, the table.
  std::vector<Eigen::Isometry3d> ct_from_depth;  ///< One a view.
};

/// How many values each of them has.
struct BundleSizes {
  std::size_t skin = 0;
  std::size_t table = 0;  ///< 0: none is seen.
};

/// What the data say about a state: the poses eliminated (Schur complement), the prior left out.
struct BundleInformation {
  Eigen::MatrixXd matrix;
  /// How a view's pose follows the parameters when it is found on the skin alone, as by tracking:
  /// rotation about `pivot_mm` in rad and shift in mm.
  std::vector<Eigen::MatrixXd> pose_from_values;
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();
};

/// How well one view's readings lie on the skin.
struct ViewFit {
  double sum_sq_mm2 = 0.0;  ///< Weighted; readings far off count as the kernel's limit.
  double sum_weights = 0.0;
};

/// A bundle adjustment over views of one body: Gauss-Newton on robust distances of the readings
/// from the planes of skin and table where they are expected, poses eliminated. The views'
/// expectations hold for poses nearby; whoever moves them far draws them anew.
class Bundle {
 public:
  struct View {
    std::vector<SensorReading> readings;
    std::size_t num_on_skin = 0;  ///< The first so many; the others are on the table.
  };

  /// @param pivot_mm  About the body's middle, frame ct.
  Bundle(const SensorModel& sensor,
         const BundleSizes& sizes,
         const std::vector<View>& views,
         const Eigen::MatrixXd& prior_precision,
         const Eigen::Vector3d& pivot_mm);

  /// From `state` to the fit of the views named. Values that the model does not free stay.
  void fit(std::span<const std::size_t> views,
           BundleModel model,
           BundleStart start,
           BundleState& state) const;

  /// Fits a view's pose alone, sensor and skin as they are.
  void fit_pose(std::size_t view, BundleState& state) const;

  [[nodiscard]] ViewFit judge(std::size_t view, const BundleState& state) const;

  /// Of each reading, in standard deviations of single readings; 0 where it is not used.
  [[nodiscard]] std::vector<float> residuals(std::size_t view, const BundleState& state) const;

  [[nodiscard]] BundleInformation information(std::span<const std::size_t> views,
                                              const BundleState& state) const;

 private:
  struct FreeValues;
  struct Equations;
  /// Adds readings to the equations. @param free  Null: of the pose alone.
  void linearize(std::span<const SensorReading> readings,
                 const Eigen::Isometry3d& pose,
                 const BundleState& state,
                 double scale_mm,
                 const FreeValues* free,
                 Equations& equations) const;
  double take_step(std::span<const std::size_t> views,
                   const FreeValues& free,
                   const Eigen::MatrixXd& prior,
                   double scale_mm,
                   BundleState& state) const;

  [[nodiscard]] double distance_mm(const SensorReading& reading,
                                   const BundleState& state,
                                   const Eigen::Vector3d& place_mm) const;

  const SensorModel& sensor_;
  BundleSizes sizes_;
  const std::vector<View>& views_;
  const Eigen::MatrixXd& prior_precision_;
  Eigen::Vector3d pivot_mm_;
};

}  // namespace mor::internal
