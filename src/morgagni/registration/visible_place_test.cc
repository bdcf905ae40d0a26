// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/visible_place.h"

#include <gtest/gtest.h>

#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

TEST(PlacesFacingCamera, LieOnTheSideThatTheCameraSees) {
  const TriangleMesh skin = internal::bumpy_body(60, {30.0F, -200.0F, 400.0F});
  const Eigen::Isometry3d ct_from_depth = internal::camera_before_body();
  const Eigen::Vector3d center = ct_from_depth.inverse() * Eigen::Vector3d(30.0, -200.0, 400.0);
  const auto places = places_facing_camera(skin, ct_from_depth);
  EXPECT_GT(places.size(), 50U);
  EXPECT_LE(places.size(), 300U);
  for (const auto& place : places) {
    EXPECT_GT(place.z(), 0.0);
    EXPECT_LT(place.norm(), center.norm());
  }
}

TEST(PlacesFacingCamera, AreNoneBehindTheCameraOrOfNoSkin) {
  const TriangleMesh skin = internal::bumpy_body(60, {30.0F, -200.0F, 400.0F});
  Eigen::Isometry3d away = internal::camera_before_body();
  away.linear() = away.linear() * Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitX());
  EXPECT_TRUE(places_facing_camera(skin, away).empty());
  EXPECT_TRUE(places_facing_camera({}, away).empty());
}

}  // namespace
}  // namespace mor
