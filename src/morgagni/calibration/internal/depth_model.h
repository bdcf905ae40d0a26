// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "morgagni/calibration/depth_fit.h"

namespace mor::internal {

/// A linear equation in a few unknowns: the sum of factor times unknown is `amount`, give or take
/// `sd`.
struct LinearRow {
  std::vector<std::pair<int, double>> entries;  ///< Unknown and factor.
  double amount = 0.0;
  double sd = 1.0;
};

/// The unknowns of a depth correction of one form: where they stand, what a reading says of them,
/// and what is believed beforehand. All are in mm at the reference distance.
class DepthModel {
 public:
  static constexpr double kReferenceMm = 800.0;

  /// @param near_mm, far_mm  Of the readings.
  DepthModel(const DepthFitOptions& options,
             DepthForm form,
             int width_px,
             int height_px,
             double near_mm,
             double far_mm);

  [[nodiscard]] int num_unknowns() const;

  /// What is to be added to this reading, and how uncertain it is.
  [[nodiscard]] LinearRow row(const DepthReading& reading) const;

  /// The amounts themselves, and how far they bend from control point to control point.
  [[nodiscard]] std::vector<LinearRow> prior() const;

  [[nodiscard]] DepthCorrection correction(const Eigen::VectorXd& unknowns) const;
  /// The other way. @pre Made by correction() of this model.
  [[nodiscard]] Eigen::VectorXd unknowns(const DepthCorrection& correction) const;

 private:
  [[nodiscard]] int num_points() const { return columns_ * rows_; }
  [[nodiscard]] int fields() const { return form_ == DepthForm::kDisparity ? 2 : 1; }
  void add_knots(double z_mm, LinearRow& row) const;

  int columns_;
  int rows_;
  DepthForm form_;
  int width_px_;
  int height_px_;
  double near_mm_;
  double far_mm_;
  std::vector<double> knots_mm_;
};

}  // namespace mor::internal
