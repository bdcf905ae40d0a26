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

/// What lies under a pixel of a frame's colour picture. None: the camera has no depth there.
/// @param shown  Has a pose.
[[nodiscard]] std::optional<TouchedPoint> touched_point(const TrackedFrame& shown,
                                                        const Eigen::Vector2d& color_pixel);

/// The error bound at what a frame shows at a place of its picture.
/// @param share  The place: 0..1 of the picture's width and height.
/// @return mm. None: no pose, no covariance or no depth there.
[[nodiscard]] std::optional<double> bound_at_mm(const TrackedFrame& shown,
                                                const Eigen::Vector2d& share);

}  // namespace mor
