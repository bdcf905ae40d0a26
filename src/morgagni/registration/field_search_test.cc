// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/field_search.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor::internal {
namespace {

std::shared_ptr<const FixedSurface> body() {
  static const auto surface = bumpy_surface();
  return surface;
}

Eigen::Vector3d body_center() {
  return body()->mesh.bounds().center().cast<double>();
}

void add_noise(PointCloud& cloud) {
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0.0F, 0.7F);
  for (auto& point : cloud.points) point += noise(random) * point.normalized();
}

/// What the camera before the body sees, with a sensor's noise and with an error that is slow over
/// the picture.
PointCloud seen_with_slow_error(double slow_mm) {
  PointCloud cloud = seen_by_camera(body()->mesh, camera_before_body());
  for (auto& point : cloud.points) {
    point += static_cast<float>(slow_mm) * std::sin(point.x() / 40.0F) * point.normalized();
  }
  add_noise(cloud);
  return cloud;
}

TEST(FieldAlignment, CountsNoPointsAsNearThatLieOnSkinFacingAway) {
  const Eigen::Isometry3d truth = camera_before_body();
  PointCloud cloud = seen_by_camera(body()->mesh, truth);
  const std::size_t num_seen = cloud.size();
  // As many points on the far side, as if the camera looked into an open body.
  const Eigen::Isometry3d behind =
      motion_about(body_center(), Eigen::Vector3d::UnitZ(), 3.1, Eigen::Vector3d::Zero()) * truth;
  const PointCloud far_side = seen_by_camera(body()->mesh, behind);
  const Eigen::Isometry3f depth_from_behind = (truth.inverse() * behind).cast<float>();
  for (const auto& point : far_side.points) {
    cloud.points.push_back(depth_from_behind * point);
    cloud.normals.push_back(-cloud.points.back().normalized());
  }
  ASSERT_GT(cloud.size(), num_seen + num_seen / 2);
  FieldAlignment alignment(body()->field, cloud, truth, {.shift_mm = 30.0, .rotation_rad = 0.35});
  const PoseFit fit = alignment.fit(kCloseLook);
  EXPECT_LT(fit.near_fraction, 0.65);
  // What is near follows the skin.
  EXPECT_GT(fit.share_of_near(), 0.9);
}

/// The body before one end of a table that is most of what is seen.
PointCloud seen_at_end_of_table() {
  PointCloud cloud = seen_by_camera(body()->mesh, camera_before_body());
  float farthest_mm = 0.0F;
  for (const auto& point : cloud.points) farthest_mm = std::max(farthest_mm, point.z());
  for (float x_mm = -150.0F; x_mm < 900.0F; x_mm += 6.0F) {
    for (float y_mm = -200.0F; y_mm < 200.0F; y_mm += 6.0F) {
      if (x_mm < 150.0F && std::abs(y_mm) < 170.0F) continue;
      cloud.points.emplace_back(x_mm, y_mm, farthest_mm + 20.0F);
      cloud.normals.emplace_back(0.0F, 0.0F, -1.0F);
    }
  }
  add_noise(cloud);
  return cloud;
}

double error_at_center_mm(const Eigen::Isometry3d& fixed_from_moving) {
  const Eigen::Isometry3d truth = camera_before_body();
  return (fixed_from_moving.inverse() * body_center() - truth.inverse() * body_center()).norm();
}

TEST(FieldSearch, FindsABodyFromStartsThatAreTurnedAboutTheTableItLiesOn) {
  const Eigen::Isometry3d truth = camera_before_body();
  const PointCloud moving = seen_at_end_of_table();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& point : moving.points) middle += point.cast<double>();
  middle = truth * (middle / static_cast<double>(moving.size()));
  const auto registration = *make_fine_registration(body(), {});
  double farthest_start_mm = 0.0;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d axis(std::cos(0.52 * i), std::sin(0.52 * i), i % 3 - 1.0);
    const Eigen::Isometry3d start =
        motion_about(middle, axis, 0.35, Eigen::Vector3d::Zero()) * truth;
    farthest_start_mm = std::max(farthest_start_mm, error_at_center_mm(start));
    const auto result = *registration->align(moving, start, StartQuality::kRough);
    EXPECT_LT(error_at_center_mm(result.fixed_from_moving), 2.0) << i;
  }
  EXPECT_GT(farthest_start_mm, 120.0);
}

TEST(FieldSearch, IsSoonContentUnderASensorsSlowError) {
  const Eigen::Isometry3d truth = camera_before_body();
  const PointCloud moving = seen_with_slow_error(3.5);
  const Eigen::Isometry3d start =
      motion_about(body_center(), {0.3, 1.0, 0.2}, 0.15, {10.0, -8.0, 12.0}) * truth;
  const auto registration = *make_fine_registration(body(), {});
  const auto result = *registration->align(moving, start, StartQuality::kRough);
  EXPECT_LT(error_at_center_mm(result.fixed_from_moving), 3.0);
  // Both approaches and one refinement; a search around the start takes some hundred steps.
  EXPECT_LT(result.num_iterations, 60);
}

}  // namespace
}  // namespace mor::internal
