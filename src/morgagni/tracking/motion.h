// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>

#include <Eigen/Geometry>

#include "morgagni/geometry/rigid.h"

namespace mor {

/// Foresees where the camera will be: on with the speed of the last two poses.
class Motion {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  void add(const Eigen::Isometry3d& ct_from_depth, TimePoint when);
  void forget() { last_.reset(); }

  [[nodiscard]] bool is_known() const { return last_.has_value(); }
  /// The last pose. Needs is_known().
  [[nodiscard]] const Eigen::Isometry3d& last() const { return *last_; }
  [[nodiscard]] TimePoint last_at() const { return last_at_; }

  /// Needs is_known(). The last pose itself after a gap: an old speed says nothing.
  [[nodiscard]] Eigen::Isometry3d expected(TimePoint when) const;

 private:
  std::optional<Eigen::Isometry3d> last_;
  TimePoint last_at_;
  Eigen::Vector3d shift_mm_per_s_ = Eigen::Vector3d::Zero();  ///< In the camera's own frame.
  Eigen::Vector3d turn_rad_per_s_ = Eigen::Vector3d::Zero();
};

}  // namespace mor
