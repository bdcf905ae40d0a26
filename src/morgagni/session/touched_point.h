// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "morgagni/tracking/tracker.h"

namespace mor {

/// A CT point under a finger on the picture.
struct TouchedPoint {
  Eigen::Vector3d ct_mm = Eigen::Vector3d::Zero();
  std::optional<double> bound_mm;  ///< 95 % of the errors there are smaller. None: not known.
  TrackingState state = TrackingState::kWaiting;
};

}  // namespace mor
