// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/skin_view.h"

#include <cmath>

#include <gtest/gtest.h>

#include "morgagni/registration/testing/test_body.h"

namespace mor::internal {
namespace {

constexpr float kToleranceMm = 8.0F;

const TriangleMesh& body() {
  static const TriangleMesh mesh = bumpy_body(120, Eigen::Vector3f(10.0F, -20.0F, 30.0F));
  return mesh;
}

Eigen::Isometry3d camera() {
  Eigen::Isometry3d ct_from_depth(Eigen::Translation3d(10.0, -20.0, -570.0));
  return ct_from_depth;
}

Eigen::Isometry3d shifted(double x_mm, double z_mm) {
  return Eigen::Translation3d(x_mm, 0.0, z_mm) * camera();
}

TEST(SkinView, SeesTheSkinWhereItIs) {
  const RangeMap map(seen_by_camera(body(), camera()));
  const SkinView view = SkinProbe(body()).look(map, camera(), kToleranceMm);
  EXPECT_GT(view.num_seen, 100);
  EXPECT_EQ(view.num_floating, 0);
  EXPECT_EQ(view.num_covered, 0);
  EXPECT_LT(view.absent_fraction(), 0.03);
}

TEST(SkinView, FindsSkinFloatingWhereThePoseBringsItTooNear) {
  const RangeMap map(seen_by_camera(body(), camera()));
  // The camera farther along its line of sight: the skin before what it sees.
  const SkinView near = SkinProbe(body()).look(map, shifted(0.0, 30.0), kToleranceMm);
  EXPECT_GT(near.floating_fraction(), 0.9);
  const SkinView far = SkinProbe(body()).look(map, shifted(0.0, -30.0), kToleranceMm);
  EXPECT_EQ(far.num_floating, 0);
  EXPECT_GT(far.num_covered, far.num_seen);
}

TEST(SkinView, MissesSkinBesideTheBody) {
  PointCloud half = seen_by_camera(body(), camera());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < half.size(); ++i) {
    // A hole in the middle of what is seen.
    if (half.points[i].head<2>().norm() > 40.0F) half.points[kept++] = half.points[i];
  }
  half.points.resize(kept);
  const SkinView view = SkinProbe(body()).look(RangeMap(half), camera(), kToleranceMm);
  EXPECT_GT(view.num_missing, 10);
  EXPECT_NEAR(view.absent_fraction(),
              static_cast<double>(view.num_missing) / (view.num_missing + view.num_seen),
              0.01);
}

TEST(SkinView, TakesWhatIsCoveredForNeitherSeenNorAbsent) {
  PointCloud covered = seen_by_camera(body(), camera());
  for (auto& point : covered.points) {
    if (point.x() > 0.0F) point *= 0.8F;
  }
  const SkinView view = SkinProbe(body()).look(RangeMap(covered), camera(), kToleranceMm);
  EXPECT_GT(view.num_covered, view.num_seen / 2);
  EXPECT_LT(view.floating_fraction(), 0.02);
}

TEST(SkinView, SaysThatAllIsAbsentWhereNothingIsSeen) {
  const SkinView view = SkinProbe(body()).look(RangeMap({}), camera(), kToleranceMm);
  EXPECT_EQ(view.absent_fraction(), 1.0);
  EXPECT_EQ(view.floating_fraction(), 0.0);
}

TEST(RangeMap, HasNothingBehindTheCameraNorBesideThePicture) {
  const RangeMap map(PointCloud{{{0.0F, 0.0F, 500.0F}, {50.0F, 50.0F, 500.0F}}, {}});
  ASSERT_NE(map.at({0.0F, 0.0F, 400.0F}), nullptr);
  EXPECT_EQ(map.at({0.0F, 0.0F, 400.0F})->nearest_mm, 500.0F);
  EXPECT_EQ(map.at({0.0F, 0.0F, -400.0F}), nullptr);
  EXPECT_EQ(map.at({-50.0F, 0.0F, 500.0F}), nullptr);
  EXPECT_EQ(map.at({std::nanf(""), 0.0F, 500.0F}), nullptr);
}

TEST(SkinProbe, FindsTheMiddleOfTheSkinThatFacesTheCamera) {
  const Eigen::Vector3d middle = SkinProbe(body()).facing_center(camera());
  EXPECT_NEAR(middle.x(), 10.0, 15.0);
  EXPECT_NEAR(middle.y(), -20.0, 15.0);
  EXPECT_LT(middle.z(), 0.0);
}

}  // namespace
}  // namespace mor::internal
