// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/sensor_points.h"

namespace mor::internal {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr int kStepPx = 3;  ///< Between the points that are taken.
constexpr float kNormalRadiusMm = 15.0F;
constexpr float kLeastFacing = 0.2F;
constexpr std::size_t kLeastPairs = 300;
/// Tukey's scale of each round, and how many steps it takes at the most.
constexpr std::array<std::pair<float, int>, 3> kRounds{{{50.0F, 12}, {20.0F, 8}, {8.0F, 8}}};
constexpr int kLastSteps = 3;  ///< With all pictures.
constexpr double kStopMm = 0.02;
/// Turns are weighed by what they move at this distance from the middle of what is seen.
constexpr double kArmMm = 300.0;
constexpr double kMostUnsureMm = 1.2;  ///< Standard deviation in the direction known least.
constexpr double kLeastExplained = 0.7;

struct Point {
  Eigen::Vector3f at;
  Eigen::Vector3f normal;
};

std::vector<Point> points_of(const StartPicture& picture) {
  std::vector<Point> points;
  for (int y = kStepPx / 2; y < picture.z_mm.height(); y += kStepPx) {
    for (int x = kStepPx / 2; x < picture.z_mm.width(); x += kStepPx) {
      if (picture.z_mm(x, y) <= 0.0F) continue;
      const auto normal = picture.normal(x, y, kNormalRadiusMm);
      if (!normal) continue;
      const Eigen::Vector3f at = picture.point(x, y);
      if (-normal->dot(at) < kLeastFacing * at.norm()) continue;
      points.push_back({at, *normal});
    }
  }
  return points;
}

/// sum w (r - J twist)^2 about a motion, twist = (turn about the middle in arms, shift).
struct Quadratic {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  std::size_t num_pairs = 0;
  std::size_t num_close = 0;  ///< Of those, near enough to be the same surface.
};

/// Adds the pairs with one picture to the sums; the motion is from the later picture's frame to
/// the one that `earlier` is seen from.
void add_pairs(const OtherPicture& earlier,
               const std::vector<Point>& points,
               const Eigen::Isometry3d& motion,
               const Eigen::Vector3f& middle,
               float scale_mm,
               Quadratic& sum) {
  const StartPicture& picture = *earlier.picture;
  const Eigen::Isometry3f move = motion.cast<float>();
  const Eigen::Isometry3f there = earlier.other_from_this.cast<float>();
  const auto fx = static_cast<float>(picture.camera.focal_x_px);
  const auto fy = static_cast<float>(picture.camera.focal_y_px);
  const auto cx = static_cast<float>(picture.camera.center_x_px);
  const auto cy = static_cast<float>(picture.camera.center_y_px);
  for (const auto& [at, normal_later] : points) {
    const Eigen::Vector3f p = move * at;
    const Eigen::Vector3f q = there * p;
    if (q.z() < 1.0F) continue;
    const int x = static_cast<int>(std::floor(fx * q.x() / q.z() + cx + 0.5F));
    const int y = static_cast<int>(std::floor(fy * q.y() / q.z() + cy + 0.5F));
    if (!picture.z_mm.view().contains(x, y) || picture.z_mm(x, y) <= 0.0F) continue;
    const Eigen::Vector3f normal = move.linear() * normal_later;
    const float off_mm = (there.linear() * normal).dot(picture.point(x, y) - q);
    const float noise_mm = axial_noise_mm(q.z());
    ++sum.num_pairs;
    if (std::abs(off_mm) < 3.0F * noise_mm + 2.0F) ++sum.num_close;
    const float ratio = off_mm / (scale_mm + 2.0F * noise_mm);
    if (std::abs(ratio) >= 1.0F) continue;
    const float rest = 1.0F - ratio * ratio;
    const double weight = rest * rest / (2.0F * noise_mm * noise_mm);
    Vector6d row;
    row.head<3>() = ((p - middle).cross(normal)).cast<double>() / kArmMm;
    row.tail<3>() = normal.cast<double>();
    sum.information += weight * row * row.transpose();
    sum.gradient += weight * static_cast<double>(off_mm) * row;
  }
}

/// One step's twist.
Vector6d solved(const Quadratic& sum) {
  return (sum.information + 1e-6 * Matrix6d::Identity()).ldlt().solve(sum.gradient);
}

/// The twist's turn is about `middle`, in arms.
Eigen::Isometry3d moved(const Vector6d& twist,
                        const Eigen::Vector3f& middle,
                        const Eigen::Isometry3d& motion) {
  const Eigen::Translation3d from_middle(middle.cast<double>());
  Vector6d turn = Vector6d::Zero();
  turn.head<3>() = twist.head<3>() / kArmMm;
  return orthonormalized(Eigen::Translation3d(twist.tail<3>()) * from_middle * se3_exp(turn) *
                         from_middle.inverse() * motion);
}

}  // namespace

std::optional<Eigen::Isometry3d> camera_motion(const StartPicture& earlier,
                                               const StartPicture& later,
                                               const std::vector<OtherPicture>& others) {
  const std::vector<Point> points = points_of(later);
  if (points.size() < kLeastPairs) return std::nullopt;
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const auto& point : points) middle += point.at / static_cast<float>(points.size());
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  Quadratic sum;
  for (const auto& [scale_mm, max_steps] : kRounds) {
    for (int step = 0; step < max_steps; ++step) {
      sum = {};
      add_pairs({&earlier}, points, motion, middle, scale_mm, sum);
      if (sum.num_pairs < kLeastPairs) return std::nullopt;
      const Vector6d twist = solved(sum);
      motion = moved(twist, middle, motion);
      if (twist.norm() < kStopMm) break;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(sum.information, Eigen::EigenvaluesOnly);
  const bool is_sure = axes.eigenvalues()[0] > 1.0 / (kMostUnsureMm * kMostUnsureMm);
  const bool is_explained =
      static_cast<double>(sum.num_close) > kLeastExplained * static_cast<double>(sum.num_pairs);
  if (!is_sure || !is_explained) return std::nullopt;
  for (int step = 0; !others.empty() && step < kLastSteps; ++step) {
    sum = {};
    add_pairs({&earlier}, points, motion, middle, kRounds.back().first, sum);
    for (const auto& other : others) {
      add_pairs(other, points, motion, middle, kRounds.back().first, sum);
    }
    motion = moved(solved(sum), middle, motion);
  }
  return motion;
}

}  // namespace mor::internal
