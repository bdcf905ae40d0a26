// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/hand_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "morgagni/camera/internal/random.h"

namespace mor::internal {
namespace {

constexpr double kTurnRad = 2.0 * std::numbers::pi;
constexpr double kDegree = std::numbers::pi / 180.0;
/// The hand comes to its full swing in this time.
constexpr double kRampS = 12.0;
constexpr double kPassRampS = 50.0;

enum MotionIndex : std::size_t { kAround, kAlong, kDistance, kPan, kTilt, kRoll, kShift };

/// Amplitudes in rad and mm, periods in s. Sums of their greatest speeds stay below a careful
/// hand's, the ramp and the tremor included (hand_path_test.cc).
struct Swing {
  double amplitude;
  double period_s;
};
constexpr std::array<Swing, 7> kOrbitSwings = {{{20.0 * kDegree, 21.0},
                                                {9.0 * kDegree, 14.0},
                                                {35.0, 11.0},
                                                {2.0 * kDegree, 8.0},
                                                {2.0 * kDegree, 9.5},
                                                {4.0 * kDegree, 12.0},
                                                {12.0, 7.0}}};
constexpr std::array<Swing, 7> kSwaySwings = {{{2.0 * kDegree, 9.0},
                                               {1.5 * kDegree, 7.0},
                                               {10.0, 8.0},
                                               {1.0 * kDegree, 6.0},
                                               {1.0 * kDegree, 7.5},
                                               {1.0 * kDegree, 9.0},
                                               {5.0, 5.0}}};
/// All around what lies upwards, slower: the way is long.
constexpr std::array<Swing, 7> kPassSwings = {{{70.0 * kDegree, 100.0},
                                               {16.0 * kDegree, 37.0},
                                               {35.0, 23.0},
                                               {2.0 * kDegree, 12.0},
                                               {2.0 * kDegree, 14.5},
                                               {4.0 * kDegree, 19.0},
                                               {12.0, 11.0}}};
/// Near and far, rolled, and the body through much of the picture, as self-calibration wants it.
constexpr std::array<Swing, 7> kSweepSwings = {{{50.0 * kDegree, 60.0},
                                                {20.0 * kDegree, 37.0},
                                                {160.0, 25.0},
                                                {4.0 * kDegree, 13.0},
                                                {4.0 * kDegree, 15.5},
                                                {25.0 * kDegree, 21.0},
                                                {12.0, 9.0}}};
/// How far from straight in front the path begins: a user aims by eye.
constexpr std::array<double, 7> kStartReach = {
    2.5 * kDegree, 2.5 * kDegree, 15.0, 1.0 * kDegree, 1.0 * kDegree, 2.0 * kDegree, 8.0};

double smooth_step(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

}  // namespace

HandPath::HandPath(const Eigen::AlignedBox3f& bounds,
                   double distance_mm,
                   SimulatedPath path,
                   std::uint64_t seed)
    : path_(path),
      target_(bounds.center().cast<double>()),
      target_distance_mm_(distance_mm + 0.5 * static_cast<double>(bounds.sizes().y())) {
  const auto& swings = path == SimulatedPath::kPass    ? kPassSwings
                       : path == SimulatedPath::kSweep ? kSweepSwings
                       : path == SimulatedPath::kOrbit ? kOrbitSwings
                                                       : kSwaySwings;
  for (std::size_t i = 0; i < kNumMotions; ++i) {
    // Periods differ by seed too, or every run would swing in the same rhythm.
    const double stretch = 1.0 + 0.2 * to_unit(scramble(seed + 1000 + i));
    motions_[i] = {swings[i].amplitude,
                   swings[i].period_s * stretch,
                   kTurnRad * to_unit(scramble(seed + 2000 + i))};
    start_[i] = kStartReach[i] * (2.0 * to_unit(scramble(seed + 3000 + i)) - 1.0);
  }
  for (std::size_t i = 0; i < tremor_phase_rad_.size(); ++i) {
    tremor_phase_rad_[i] = kTurnRad * to_unit(scramble(seed + 4000 + i));
  }
}

double HandPath::value(std::size_t motion, double time_s) const {
  if (path_ == SimulatedPath::kStill) return start_[motion];
  const auto& [amplitude, period_s, phase_rad] = motions_[motion];
  const double ramp_s = path_ == SimulatedPath::kPass ? kPassRampS : kRampS;
  return start_[motion] + smooth_step(time_s / ramp_s) * amplitude *
                              std::sin(kTurnRad * time_s / period_s + phase_rad);
}

/// Physiological tremor lies at 6 to 12 Hz. Unit amplitude.
double HandPath::tremor(std::size_t axis, double time_s) const {
  if (path_ == SimulatedPath::kStill) return 0.0;
  const double rate_hz = 6.0 + 0.7 * static_cast<double>(axis);
  return std::sin(kTurnRad * rate_hz * time_s + tremor_phase_rad_[axis]);
}

Eigen::Isometry3d HandPath::ct_from_camera(double time_s) const {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  constexpr double kTremorMm = 0.15;
  constexpr double kTremorRad = 0.025 * kDegree;
  // Straight in front: x to the patient's left, y to the feet, z to the back.
  Eigen::Matrix3d ct_from_front;
  ct_from_front.col(0) = Vector3d::UnitX();
  ct_from_front.col(1) = -Vector3d::UnitZ();
  ct_from_front.col(2) = Vector3d::UnitY();
  // Swings about the body: around its long axis, then towards head and feet.
  const Eigen::Matrix3d looking = ct_from_front *
                                  AngleAxisd(value(kAround, time_s), Vector3d::UnitY()) *
                                  AngleAxisd(value(kAlong, time_s), Vector3d::UnitX());
  const Vector3d offset(
      value(kShift, time_s) + kTremorMm * tremor(0, time_s),
      kTremorMm * tremor(1, time_s),
      kTremorMm * tremor(2, time_s) - target_distance_mm_ - value(kDistance, time_s));
  Eigen::Isometry3d ct_from_camera = Eigen::Isometry3d::Identity();
  ct_from_camera.translation() = target_ + looking * offset;
  ct_from_camera.linear() =
      looking *
      (AngleAxisd(value(kPan, time_s) + kTremorRad * tremor(3, time_s), Vector3d::UnitY()) *
       AngleAxisd(value(kTilt, time_s) + kTremorRad * tremor(4, time_s), Vector3d::UnitX()) *
       AngleAxisd(value(kRoll, time_s) + kTremorRad * tremor(5, time_s), Vector3d::UnitZ()))
          .toRotationMatrix();
  return ct_from_camera;
}

}  // namespace mor::internal
