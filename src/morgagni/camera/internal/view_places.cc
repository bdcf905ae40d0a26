// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/view_places.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "morgagni/camera/internal/random.h"

namespace mor::internal {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kTurnRad = 2.0 * std::numbers::pi;
constexpr double kAimRad = 4.0 * std::numbers::pi / 180.0;
/// Rays are sent through a box of this share of the body's, about its middle.
constexpr double kMiddleShare = 0.5;
/// A place seen at a flatter angle than this is none that a user would look at.
constexpr double kLeastFacing = 0.2;
constexpr int kMaxTries = 200;

/// Even over the sphere's cap above the least elevation; up is -y.
Vector3d draw_direction(Draws& draw) {
  const double up = draw(std::sin(ViewPlaces::kLeastElevationRad), 1.0);
  const double azimuth_rad = draw(0.0, kTurnRad);
  const double level = std::sqrt(1.0 - up * up);
  return {level * std::cos(azimuth_rad), -up, level * std::sin(azimuth_rad)};
}

constexpr double kDriftPeriodS = 3.0;  ///< There and back.
constexpr double kLeastDriftMm = 50.0;
constexpr double kMostDriftMm = 100.0;
constexpr double kMostDriftTurnRad = 5.0 * std::numbers::pi / 180.0;

/// A camera at `eye` that looks along `forward`, turned about it by `roll_rad`.
Eigen::Isometry3d looking(const Vector3d& eye, const Vector3d& forward, double roll_rad) {
  const Vector3d level = forward.unitOrthogonal();
  const Vector3d right = std::cos(roll_rad) * level + std::sin(roll_rad) * forward.cross(level);
  Eigen::Isometry3d ct_from_camera = Eigen::Isometry3d::Identity();
  ct_from_camera.linear().col(0) = right;
  ct_from_camera.linear().col(1) = forward.cross(right);
  ct_from_camera.linear().col(2) = forward;
  ct_from_camera.translation() = eye;
  return ct_from_camera;
}

/// How far from where it began, of all the way there and back again.
double way_share(double held_s, double period_s) {
  return 0.5 - 0.5 * std::cos(kTurnRad * held_s / period_s);
}

/// `held` after a while on its way to one side, level; it looks on at the point at `distance_mm`.
Eigen::Isometry3d walked(
    const Eigen::Isometry3d& held, double distance_mm, double held_s, double walk_mm, Draws draw) {
  const Vector3d forward = held.linear().col(2);
  const Vector3d across = forward.cross(Vector3d::UnitY());
  const Vector3d level = across.norm() > 1e-3 ? across.normalized() : Vector3d(Vector3d::UnitX());
  const double side = draw(-1.0, 1.0) < 0.0 ? -1.0 : 1.0;
  const double share = way_share(held_s, 2.0 * walk_mm / ViewPlaces::kWalkMmPerS);
  const Vector3d shift_mm = held.linear().transpose() * (side * share * walk_mm * level);
  const Vector3d to_target = Vector3d(0.0, 0.0, distance_mm) - shift_mm;
  return held * Eigen::Translation3d(shift_mm) *
         Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), to_target);
}

/// `held` after a while in a hand: drifted about the point at `distance_mm` before the camera.
Eigen::Isometry3d drifted(const Eigen::Isometry3d& held,
                          double distance_mm,
                          double held_s,
                          Draws draw) {
  const double up = draw(-1.0, 1.0);
  const double azimuth_rad = draw(0.0, kTurnRad);
  const double level = std::sqrt(1.0 - up * up);
  const double share = way_share(held_s, kDriftPeriodS);
  const Vector3d shift_mm =
      share * draw(kLeastDriftMm, kMostDriftMm) *
      Vector3d(level * std::cos(azimuth_rad), level * std::sin(azimuth_rad), up);
  // The target stays in the middle; what the hand does not manage is the wandering after it.
  const Vector3d to_target = Vector3d(0.0, 0.0, distance_mm) - shift_mm;
  const Eigen::Quaterniond aim = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), to_target);
  const auto wander_rad = [&] { return share * draw(-kMostDriftTurnRad, kMostDriftTurnRad); };
  const double pan_rad = wander_rad();
  const double tilt_rad = wander_rad();
  const double roll_rad = wander_rad();
  return held * Eigen::Translation3d(shift_mm) * aim *
         Eigen::AngleAxisd(pan_rad, Vector3d::UnitY()) *
         Eigen::AngleAxisd(tilt_rad, Vector3d::UnitX()) *
         Eigen::AngleAxisd(roll_rad, Vector3d::UnitZ());
}

}  // namespace

ViewPlaces::ViewPlaces(std::shared_ptr<const TriangleMesh> skin,
                       std::optional<double> distance_mm,
                       std::uint64_t seed,
                       std::optional<double> walk_mm)
    : skin_(std::move(skin)),
      distance_mm_(distance_mm),
      seed_(seed),
      walk_mm_(walk_mm),
      bounds_(skin_->bounds().cast<double>()) {}

/// Moller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997, for every
/// triangle.
std::optional<Vector3d> ViewPlaces::first_hit(const Vector3d& through,
                                              const Vector3d& to_camera) const {
  const Vector3f start = (through + bounds_.diagonal().norm() * to_camera).cast<float>();
  const Vector3f ray = -to_camera.cast<float>();
  float nearest_mm = std::numeric_limits<float>::infinity();
  float facing = 0.0F;
  for (const auto& [ia, ib, ic] : skin_->triangles) {
    const Vector3f& a = skin_->vertices[ia];
    const Vector3f to_b = skin_->vertices[ib] - a;
    const Vector3f to_c = skin_->vertices[ic] - a;
    const Vector3f across = ray.cross(to_c);
    const float determinant = to_b.dot(across);
    if (std::abs(determinant) < 1e-12F) continue;
    const Vector3f from_a = start - a;
    const float u = from_a.dot(across) / determinant;
    if (u < 0.0F || u > 1.0F) continue;
    const Vector3f normal_side = from_a.cross(to_b);
    const float v = ray.dot(normal_side) / determinant;
    if (v < 0.0F || u + v > 1.0F) continue;
    const float distance_mm = to_c.dot(normal_side) / determinant;
    if (distance_mm <= 0.0F || distance_mm >= nearest_mm) continue;
    nearest_mm = distance_mm;
    facing = -to_b.cross(to_c).normalized().dot(ray);
  }
  // The inside of the skin shows where the CT ends: that is no place to look at.
  if (facing < static_cast<float>(kLeastFacing)) return std::nullopt;
  return (start + nearest_mm * ray).cast<double>();
}

Eigen::Isometry3d ViewPlaces::ct_from_camera(std::uint64_t view, double held_s) const {
  const std::uint64_t counter = scramble(scramble(seed_ ^ 0x5649455753U) ^ view);
  Draws draw(counter);
  const Vector3d half = 0.5 * kMiddleShare * bounds_.sizes();
  Vector3d to_camera = -Vector3d::UnitY();
  std::optional<Vector3d> seen;
  for (int i = 0; i < kMaxTries && !seen; ++i) {
    to_camera = draw_direction(draw);
    const Vector3d offset(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0));
    seen = first_hit(bounds_.center() + half.cwiseProduct(offset), to_camera);
  }
  const double distance_mm = distance_mm_.value_or(draw(kNearestMm, kFarthestMm));
  const Vector3d eye = seen.value_or(bounds_.center()) + distance_mm * to_camera;
  const auto aimed = looking(eye, -to_camera, draw(0.0, kTurnRad));
  const double pan_rad = draw(-kAimRad, kAimRad);
  const double tilt_rad = draw(-kAimRad, kAimRad);
  const Eigen::Isometry3d held = aimed * Eigen::AngleAxisd(pan_rad, Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(tilt_rad, Vector3d::UnitX());
  if (held_s <= 0.0) return held;
  const Draws of_hand(scramble(counter + 1));
  return walk_mm_ ? walked(held, distance_mm, held_s, *walk_mm_, of_hand)
                  : drifted(held, distance_mm, held_s, of_hand);
}

}  // namespace mor::internal
