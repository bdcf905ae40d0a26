// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/view_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace mor::internal {
namespace {

constexpr double kTableMm = 90.0;

/// A half cylinder over the table, 100 mm in radius and 400 mm long: open at both ends, as the
/// skin is where a CT ends.
std::shared_ptr<const TriangleMesh> open_body() {
  auto mesh = std::make_shared<TriangleMesh>();
  constexpr unsigned kAround = 90;
  constexpr unsigned kAlong = 40;
  for (unsigned row = 0; row <= kAlong; ++row) {
    for (unsigned column = 0; column < kAround; ++column) {
      const double angle_rad = 2.0 * std::numbers::pi * column / kAround;
      mesh->vertices.emplace_back(static_cast<float>(100.0 * std::cos(angle_rad)),
                                  static_cast<float>(90.0 * std::sin(angle_rad)),
                                  10.0F * static_cast<float>(row));
    }
  }
  for (unsigned row = 0; row < kAlong; ++row) {
    for (unsigned column = 0; column < kAround; ++column) {
      const unsigned next = (column + 1) % kAround;
      const unsigned a = row * kAround + column;
      const unsigned b = row * kAround + next;
      mesh->triangles.push_back({a, b, a + kAround});
      mesh->triangles.push_back({b, b + kAround, a + kAround});
    }
  }
  return mesh;
}

/// What the camera looks at: the skin's point nearest to the middle ray.
double off_axis_rad(const TriangleMesh& skin, const Eigen::Isometry3d& ct_from_camera) {
  const Eigen::Isometry3d camera_from_ct = ct_from_camera.inverse();
  double least_rad = std::numbers::pi;
  for (const auto& vertex : skin.vertices) {
    const Eigen::Vector3d p = camera_from_ct * vertex.cast<double>();
    least_rad = std::min(least_rad, std::atan2(p.head<2>().norm(), p.z()));
  }
  return least_rad;
}

TEST(ViewPlaces, LieAllOverTheUpperHalfSpaceWithinReach) {
  const auto skin = open_body();
  const ViewPlaces views(skin, std::nullopt, 1);
  std::vector<int> by_octant(4, 0);
  std::vector<int> by_roll(4, 0);
  double lowest_rad = 1.0;
  double highest_rad = 0.0;
  for (std::uint64_t id = 0; id < 400; ++id) {
    const auto pose = views.ct_from_camera(id);
    ASSERT_NEAR((pose.linear().transpose() * pose.linear() - Eigen::Matrix3d::Identity()).norm(),
                0.0,
                1e-9);
    ASSERT_NEAR(pose.linear().determinant(), 1.0, 1e-9);
    ASSERT_LT(pose.translation().y(), kTableMm);
    double nearest_mm = 1e9;
    for (const auto& vertex : skin->vertices) {
      nearest_mm = std::min(nearest_mm, (vertex.cast<double>() - pose.translation()).norm());
    }
    ASSERT_GT(nearest_mm, 300.0);  // The skin beside the place looked at may come nearer.
    ASSERT_LT(nearest_mm, ViewPlaces::kFarthestMm + 10.0);
    ASSERT_LT(off_axis_rad(*skin, pose), 0.11);
    const Eigen::Vector3d forward = pose.linear().col(2);
    // The aim is off by less than six degrees.
    const double elevation_rad = std::asin(forward.y());
    ASSERT_GT(elevation_rad, ViewPlaces::kLeastElevationRad - 0.1);
    lowest_rad = std::min(lowest_rad, elevation_rad);
    highest_rad = std::max(highest_rad, elevation_rad);
    ++by_octant[(forward.x() > 0.0 ? 1U : 0U) + (forward.z() > 0.0 ? 2U : 0U)];
    const Eigen::Vector3d level = forward.unitOrthogonal();
    const double sine = pose.linear().col(0).dot(forward.cross(level));
    const double cosine = pose.linear().col(0).dot(level);
    ++by_roll[(sine > 0.0 ? 1U : 0U) + (cosine > 0.0 ? 2U : 0U)];
  }
  EXPECT_LT(lowest_rad, 0.35);
  EXPECT_GT(highest_rad, 1.4);
  for (const auto& counts : {by_octant, by_roll}) {
    for (const int count : counts) EXPECT_GT(count, 60);
  }
}

TEST(ViewPlaces, LookAtTheOutsideOfTheSkin) {
  const auto skin = open_body();
  const ViewPlaces views(skin, 700.0, 2);
  for (std::uint64_t id = 0; id < 100; ++id) {
    const auto pose = views.ct_from_camera(id);
    // 700 mm along the aim, which lies within 4 degrees each way of the middle ray, there is skin
    // that faces the camera: outside, and the nearest of its ray.
    double least_off_mm = 1e9;
    for (const auto& vertex : skin->vertices) {
      const Eigen::Vector3d p = vertex.cast<double>();
      const Eigen::Vector3d outward(p.x() / 1e4, p.y() / 8.1e3, 0.0);
      const Eigen::Vector3d to_camera = pose.translation() - p;
      if (outward.dot(to_camera) <= 0.0) continue;
      least_off_mm = std::min(least_off_mm, std::abs(to_camera.norm() - 700.0));
    }
    EXPECT_LT(least_off_mm, 8.0);
  }
}

TEST(ViewPlaces, AreTheSameForTheSameSeedInWhateverOrder) {
  const auto skin = open_body();
  const ViewPlaces views(skin, std::nullopt, 3);
  const auto later = views.ct_from_camera(9);
  (void)views.ct_from_camera(2);
  EXPECT_TRUE(ViewPlaces(skin, std::nullopt, 3).ct_from_camera(9).isApprox(later, 0.0));
  EXPECT_FALSE(ViewPlaces(skin, std::nullopt, 4).ct_from_camera(9).isApprox(later, 1e-3));
}

TEST(ViewPlaces, DriftInAHand) {
  const auto skin = open_body();
  const ViewPlaces views(skin, std::nullopt, 5);
  int num_turned = 0;
  for (std::uint64_t id = 0; id < 200; ++id) {
    const auto first = views.ct_from_camera(id);
    const Eigen::Isometry3d last = first.inverse() * views.ct_from_camera(id, 1.5);
    ASSERT_NEAR(last.linear().determinant(), 1.0, 1e-9);
    ASSERT_GT(last.translation().norm(), 49.9);
    ASSERT_LT(last.translation().norm(), 100.1);
    const double turn_rad = Eigen::AngleAxisd(last.linear()).angle();
    ASSERT_LT(turn_rad, 0.37);
    num_turned += turn_rad > 0.07 ? 1 : 0;
    ASSERT_LT(off_axis_rad(*skin, views.ct_from_camera(id, 1.5)), 0.25);
    const Eigen::Isometry3d soon = first.inverse() * views.ct_from_camera(id, 0.033);
    ASSERT_LT(soon.translation().norm(), 1.0);
  }
  EXPECT_GT(num_turned, 150);
}

TEST(ViewPlaces, WalkToOneSideAndLookOnAtTheSamePlace) {
  const auto skin = open_body();
  const ViewPlaces drifting(skin, std::nullopt, 5);
  const ViewPlaces views(skin, std::nullopt, 5, 300.0);
  for (std::uint64_t id = 0; id < 50; ++id) {
    const auto first = views.ct_from_camera(id);
    EXPECT_TRUE(first.isApprox(drifting.ct_from_camera(id), 0.0));
    const auto last = views.ct_from_camera(id, 3.0);
    const Eigen::Vector3d shift = last.translation() - first.translation();
    EXPECT_NEAR(shift.norm(), 300.0, 0.1);
    EXPECT_NEAR(shift.y(), 0.0, 0.1) << "level";
    EXPECT_LT(off_axis_rad(*skin, last), 0.25);
    const auto soon = views.ct_from_camera(id, 1.6);
    EXPECT_LT((soon.translation() - views.ct_from_camera(id, 1.4).translation()).norm(), 35.0);
  }
}

TEST(ViewPlaces, LookDownOnABodyThatNoRayMeets) {
  auto skin = std::make_shared<TriangleMesh>();
  skin->vertices = {{0, 0, 0}, {100, 0, 0}, {0, 0, 100}};
  skin->triangles = {{0, 1, 2}, {0, 0, 0}};
  const auto pose = ViewPlaces(skin, 600.0, 1).ct_from_camera(0);
  EXPECT_TRUE(pose.matrix().allFinite());
}

}  // namespace
}  // namespace mor::internal
