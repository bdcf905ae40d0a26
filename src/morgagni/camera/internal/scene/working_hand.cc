// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/working_hand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "morgagni/camera/internal/scene/blended_solid.h"

namespace mor::internal {
namespace {

using Eigen::AngleAxisf;
using Eigen::Vector3f;

constexpr float kDegree = std::numbers::pi_v<float> / 180.0F;
constexpr float kTurnRad = 2.0F * std::numbers::pi_v<float>;
constexpr float kCellMm = 4.0F;
constexpr float kBlendMm = 9.0F;
/// The sleeve begins this far behind the wrist.
constexpr float kCuffMm = -105.0F;

/// Nitrile, latex and bare skin; gowns.
constexpr std::array<std::array<float, 3>, 4> kGloves = {
    {{86, 128, 206}, {122, 110, 196}, {226, 220, 200}, {214, 164, 138}}};
constexpr std::array<std::array<float, 3>, 3> kSleeves = {
    {{74, 138, 122}, {84, 128, 168}, {196, 204, 206}}};

float between(Draws& draw, double least, double most) {
  return static_cast<float>(draw(least, most));
}

/// A finger of phalanges that bend down by `bend_rad` more at each joint.
void add_finger(std::vector<Limb>& limbs,
                Vector3f joint,
                float spread_rad,
                float length_mm,
                float radius_mm,
                float bend_rad) {
  constexpr std::array<float, 3> kShares = {0.46F, 0.30F, 0.24F};
  float down_rad = 0.4F * bend_rad;
  for (const float share : kShares) {
    const Vector3f along(std::cos(down_rad) * std::cos(spread_rad),
                         std::cos(down_rad) * std::sin(spread_rad),
                         -std::sin(down_rad));
    const Vector3f next = joint + share * length_mm * along;
    limbs.push_back({joint, next, radius_mm, radius_mm - 0.9F});
    radius_mm -= 0.9F;
    joint = next;
    down_rad += bend_rad;
  }
}

std::vector<Limb> hand_limbs(Draws& draw) {
  std::vector<Limb> limbs;
  const float bend_rad = between(draw, 8.0, 34.0) * kDegree;
  const float spread = between(draw, 0.5, 1.6);
  struct Finger {
    float side_mm, reach_mm, length_mm, radius_mm;
  };
  // From the index to the little finger.
  constexpr std::array<Finger, 4> kFingers = {
      {{28, 44, 88, 9.5F}, {9, 48, 96, 9.8F}, {-10, 44, 90, 9.2F}, {-28, 36, 70, 8.4F}}};
  for (const auto& finger : kFingers) {
    const Vector3f wrist(-46.0F, 0.55F * finger.side_mm, 18.0F);
    const Vector3f knuckle(finger.reach_mm, finger.side_mm, 16.0F);
    limbs.push_back({wrist, knuckle, 15.0F, finger.radius_mm + 2.5F});
    add_finger(limbs,
               knuckle,
               spread * finger.side_mm * 0.006F,
               finger.length_mm,
               finger.radius_mm,
               bend_rad + between(draw, -4.0, 4.0) * kDegree);
  }
  const Vector3f thumb_root(-30.0F, 24.0F, 14.0F);
  const Vector3f thumb_joint = thumb_root + Vector3f(34.0F, 30.0F, -6.0F);
  limbs.push_back({thumb_root, thumb_joint, 15.0F, 11.0F});
  limbs.push_back({thumb_joint, thumb_joint + Vector3f(34.0F, 12.0F, -8.0F), 11.0F, 9.0F});
  return limbs;
}

/// Behind the wrist, rising by `rise_rad`.
std::vector<Limb> arm_limbs(float rise_rad, float length_mm) {
  const Vector3f wrist(-48.0F, 0.0F, 19.0F);
  const Vector3f back(-std::cos(rise_rad), 0.0F, std::sin(rise_rad));
  const Vector3f middle = wrist + 0.4F * length_mm * back;
  return {{wrist, middle, 26.0F, 41.0F}, {middle, wrist + length_mm * back, 41.0F, 48.0F}};
}

/// How far a surface can sink before it touches what is below; negative where it is in it.
float clearance_mm(const PaintedMesh& surface,
                   const Eigen::Isometry3f& ct_from_surface,
                   const HeightMap& ground) {
  constexpr std::size_t kEvery = 3;
  float least_mm = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); i += kEvery) {
    const Vector3f p = ct_from_surface * surface.mesh.vertices[i];
    least_mm = std::min(least_mm, ground.top(p.x(), p.z()).y() - p.y());
  }
  return least_mm;
}

}  // namespace

WorkingHand::WorkingHand(std::uint64_t seed) {
  Draws draw(scramble(seed ^ 0x48414E44U));
  auto limbs = hand_limbs(draw);
  const float rise_rad = between(draw, 14.0, 36.0) * kDegree;
  for (const auto& limb : arm_limbs(rise_rad, between(draw, 480.0, 620.0))) limbs.push_back(limb);
  if (draw(0.0, 1.0) < 0.5) {
    for (auto& limb : limbs) {
      limb.begin.y() = -limb.begin.y();
      limb.end.y() = -limb.end.y();
    }
  }
  const auto& glove = kGloves[draw.choice(kGloves.size())];
  const auto& sleeve = kSleeves[draw.choice(kSleeves.size())];
  surface_ =
      painted(blended_surface(limbs, kBlendMm, kCellMm), {glove[0], glove[1], glove[2]}, 30.0F);
  float lowest_mm = 0.0F;
  for (std::size_t i = 0; i < surface_.mesh.vertices.size(); ++i) {
    auto& p = surface_.mesh.vertices[i];
    lowest_mm = std::min(lowest_mm, p.z());
    if (p.x() > kCuffMm) continue;
    // Cloth over the arm: wider than it, and in folds around it.
    const float fold = std::sin(0.11F * p.x()) + 0.6F * std::sin(0.047F * p.x() + 0.05F * p.y());
    p += (5.0F + 1.6F * fold) * surface_.mesh.normals[i];
    surface_.albedo[i] = (1.0F + 0.05F * fold) * Vector3f(sleeve[0], sleeve[1], sleeve[2]);
    surface_.gloss[i] = 4.0F;
  }
  for (auto& p : surface_.mesh.vertices) p.z() -= lowest_mm;
  surface_.mesh.normals = vertex_normals(surface_.mesh);
}

WorkingHand::Placement WorkingHand::placed(const Eigen::AlignedBox2f& area,
                                           const HeightMap& ground,
                                           Draws& draw) const {
  constexpr int kTries = 40;
  constexpr float kLeastUp = 0.75F;
  Eigen::Vector2f at = area.center();
  Eigen::Vector2f away = Eigen::Vector2f::UnitX();
  Vector3f up = -Vector3f::UnitY();
  for (int i = 0; i < kTries; ++i) {
    const float azimuth_rad = between(draw, 0.0, kTurnRad);
    away = {std::cos(azimuth_rad), std::sin(azimuth_rad)};
    const float edge_mm = 1.0F / away.cwiseQuotient(0.5F * area.sizes()).norm();
    at = area.center() + between(draw, 0.25, 0.95) * edge_mm * away;
    up = ground.normal(at.x(), at.y());
    if (-up.y() > kLeastUp && ground.height_mm(at.x(), at.y()) > 20.0F) break;
  }
  up = (up - Vector3f::UnitY()).normalized();
  // Who works here stands outside: the arm comes from there, the fingers point inwards.
  const float aside_rad = between(draw, -50.0, 50.0) * kDegree;
  const Vector3f inwards =
      AngleAxisf(aside_rad, Vector3f::UnitY()) * Vector3f(-away.x(), 0.0F, -away.y());
  const Vector3f along = (inwards - inwards.dot(up) * up).normalized();
  Placement placement;
  placement.ct_from_hand.linear().col(0) = along;
  placement.ct_from_hand.linear().col(1) = up.cross(along);
  placement.ct_from_hand.linear().col(2) = up;
  placement.ct_from_hand.translation() = ground.top(at.x(), at.y());
  // Half of the hands rest, half hover.
  const float gap_mm = draw(0.0, 1.0) < 0.5 ? 0.0F : between(draw, 10.0, 90.0);
  placement.ct_from_hand.translation().y() +=
      clearance_mm(surface_, placement.ct_from_hand, ground) - gap_mm;
  for (int axis = 0; axis < 3; ++axis) {
    placement.motion_phase_rad[axis] = between(draw, 0.0, kTurnRad);
  }
  placement.period_s = between(draw, 6.0, 11.0);
  return placement;
}

Eigen::Isometry3f WorkingHand::moved(const Placement& placement, double time_s) {
  const auto swing = [&](int axis, float slower) {
    const auto turns = static_cast<float>(std::fmod(time_s / (slower * placement.period_s), 1.0));
    return std::sin(kTurnRad * turns + placement.motion_phase_rad[axis]);
  };
  const float lift_mm = 12.0F * (1.0F + swing(2, 0.7F));
  return placement.ct_from_hand *
         Eigen::Translation3f(28.0F * swing(0, 1.0F), 18.0F * swing(1, 1.3F), lift_mm) *
         AngleAxisf(9.0F * kDegree * swing(1, 1.7F), Vector3f::UnitZ());
}

}  // namespace mor::internal
