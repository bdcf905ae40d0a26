// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/motion.h"

namespace mor {
namespace {

/// Two poses farther apart in time say nothing of the speed now.
constexpr double kLongestGapS = 0.2;

double seconds(Motion::TimePoint from, Motion::TimePoint to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

void Motion::add(const Eigen::Isometry3d& ct_from_depth, TimePoint when) {
  const double gap_s = last_ ? seconds(last_at_, when) : 0.0;
  if (gap_s > 0.0 && gap_s <= kLongestGapS) {
    const Eigen::Isometry3d moved = last_->inverse() * ct_from_depth;
    const Eigen::AngleAxisd turned(moved.linear());
    shift_mm_per_s_ = moved.translation() / gap_s;
    turn_rad_per_s_ = turned.angle() / gap_s * turned.axis();
  } else {
    shift_mm_per_s_.setZero();
    turn_rad_per_s_.setZero();
  }
  last_ = ct_from_depth;
  last_at_ = when;
}

Eigen::Isometry3d Motion::expected(TimePoint when) const {
  const double ahead_s = seconds(last_at_, when);
  if (!(ahead_s > 0.0 && ahead_s <= kLongestGapS)) return *last_;
  const double angle_rad = ahead_s * turn_rad_per_s_.norm();
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  moved.translation() = ahead_s * shift_mm_per_s_;
  if (angle_rad > 0.0) {
    moved.linear() = Eigen::AngleAxisd(angle_rad, turn_rad_per_s_.normalized()).toRotationMatrix();
  }
  return orthonormalized(*last_ * moved);
}

}  // namespace mor
