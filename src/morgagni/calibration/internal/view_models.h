// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/calibration/internal/bundle.h"
#include "morgagni/calibration/internal/prior_evidence.h"
#include "morgagni/calibration/internal/sensor_model.h"
#include "morgagni/calibration/internal/skin_model.h"
#include "morgagni/calibration/internal/table_model.h"
#include "morgagni/calibration/self_calibration.h"

namespace mor::internal {

/// How the residuals of a fit scatter against what single readings would.
struct ReadingsScatter {
  double ratio = 1.0;       ///< Standard deviation over that of single readings.
  double correlated = 1.0;  ///< Readings that err together count as one: so many.
};

/// What is free beside the poses: sensor, skin and, where one is seen, table, with their priors;
/// and what is expected of the views' readings where these values are. The arguments must outlive
/// it.
class ViewModels {
 public:
  ViewModels(const TriangleMesh& skin,
             const PinholeCamera& depth,
             const std::vector<SensedSkin>& views,
             const SelfCalibrationOptions& options);

  [[nodiscard]] const SensorModel& sensor() const { return sensor_; }
  [[nodiscard]] const SkinModel& skin() const { return skin_; }
  [[nodiscard]] bool has_table() const { return table_.has_value(); }
  /// Places of readings on the skin, frame ct.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& seen_mm() const { return seen_mm_; }
  [[nodiscard]] const ValuePriors& priors() const { return priors_; }
  [[nodiscard]] const Eigen::MatrixXd& sensor_prior() const { return sensor_prior_; }
  [[nodiscard]] const Eigen::MatrixXd& prior_precision() const { return prior_precision_; }

  /// Nothing errs, the poses as tracked.
  [[nodiscard]] const BundleState& start() const { return start_; }
  /// The camera as these values have it.
  [[nodiscard]] PinholeCamera camera_of(const BundleState& state) const;
  /// @cost A drawing a view.
  [[nodiscard]] std::vector<Bundle::View> expected(const BundleState& state) const;
  /// @param expected  Must outlive it.
  [[nodiscard]] Bundle bundle(const std::vector<Bundle::View>& expected) const;

  [[nodiscard]] ReadingsScatter scatter_of(const std::vector<Bundle::View>& expected,
                                           const BundleState& state) const;
  /// From now on readings count as their scatter says, and all of them together as one that errs by
  /// the least systematic error: no number of readings averages that out.
  void weigh_by(const ReadingsScatter& scatter, const std::vector<Bundle::View>& expected);

  /// From now on the sensor's error goes with the distance as the views tell beforehand, and the
  /// body is as in its CT if they say so.
  /// @param information  At `state`, which was fitted to the views with sensor and skin free.
  void learn_priors(const BundleInformation& information, const BundleState& state);

 private:
  void find_seen_skin();
  void set_prior();
  void add_table(const PinholeCamera& camera,
                 const Eigen::Isometry3d& ct_from_depth,
                 const std::vector<SkinReading>& beside,
                 std::vector<SensorReading>& readings) const;

  const TriangleMesh& mesh_;
  const PinholeCamera& depth_;
  const std::vector<SensedSkin>& views_;
  const SelfCalibrationOptions& options_;
  SensorModel sensor_;
  SkinModel skin_;
  Eigen::Vector3d pivot_mm_;
  std::optional<TableModel> table_;
  BundleSizes sizes_;
  std::vector<Eigen::Vector3d> seen_mm_;
  BundleState start_;
  ValuePriors priors_;
  double weight_factor_ = 1.0;
  double table_weight_factor_ = 1.0;
  Eigen::MatrixXd skin_precision_;  ///< Of a change of 1 mm.
  Eigen::MatrixXd sensor_prior_;
  Eigen::MatrixXd prior_precision_;
};

[[nodiscard]] Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& covariance);

}  // namespace mor::internal
