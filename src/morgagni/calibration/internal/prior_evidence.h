// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "morgagni/calibration/internal/sensor_model.h"

namespace mor::internal {

/// What is expected of the sensor's error and of the skin's change before it was seen where they
/// are.
struct ValuePriors {
  DepthGrowth growth;
  double skin_mm = 0.0;  ///< Standard deviation of the skin's change.
};

/// What the views say of sensor, skin and table at a fit: a Gaussian in their values (Laplace).
struct ViewsSay {
  Eigen::MatrixXd precision;
  Eigen::VectorXd pull;  ///< `precision` times what suits the views best.
};

/// The priors by which the views are more probable (evidence). The body is as in its CT, or it has
/// changed: then the skin may have changed by as much as expected, be it less at most places. Of
/// the known ways of going with the distance the mean, each as far as it explains the views.
/// @param skin_precision  Of the skin's values, of a change of 1 mm.
/// @param expected  With a way of its own to go with the distance, and of a body that has changed.
[[nodiscard]] ValuePriors learn_priors(const SensorModel& sensor,
                                       const Eigen::MatrixXd& skin_precision,
                                       const Eigen::MatrixXd& table_precision,
                                       const ViewsSay& views,
                                       const ValuePriors& expected);

}  // namespace mor::internal
