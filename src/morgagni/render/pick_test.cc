// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/pick.h"

#include <cmath>

#include <gtest/gtest.h>

#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

using Eigen::Vector3d;

constexpr PinholeCamera kCamera{641, 479, 530.0, 528.0, 318.0, 242.0, {0.05, -0.1, 0, 0, 0}};
constexpr double kSkinMm = 60.0;
constexpr double kBoneMm = 30.0;

/// A ball in a ball of voxels, 500 mm before the camera; air in the skin's innermost 10 mm.
RenderScene ball() {
  auto volume = std::make_shared<Volume>();
  volume->size = {130, 130, 130};
  volume->ct_from_grid.translation() = Vector3d::Constant(-64.5);
  volume->hu.resize(130 * 130 * 130, kOutsideHu);
  for (int z = 0; z < 130; ++z) {
    for (int y = 0; y < 130; ++y) {
      for (int x = 0; x < 130; ++x) {
        const double r = (Vector3d(x, y, z).array() - 64.5).matrix().norm();
        if (r < kSkinMm) volume->hu[volume->index(x, y, z)] = r < 45.0 ? 900 : 0;
      }
    }
  }
  return {.structures = {{"bone", testing::make_sphere({0, 0, 0}, kBoneMm, 60), {1, 1, 1}}},
          .skin = testing::make_sphere({0, 0, 0}, kSkinMm, 60),
          .volume = volume};
}

OverlayView view(float radius = 2.0F) {
  OverlayView view{.color_camera = kCamera};
  view.color_from_ct = Eigen::Isometry3d(Eigen::AngleAxisd(0.8, Vector3d(1, 2, 3).normalized()));
  view.color_from_ct->pretranslate(Vector3d(5, -8, 500));
  view.hole.radius = radius;
  return view;
}

Eigen::Vector2d pixel_of(const OverlayView& view, const Vector3d& ct) {
  return *kCamera.project(*view.color_from_ct * ct);
}

/// Of the ball with this radius, the place that faces the camera with a small tilt.
Vector3d front(const OverlayView& view, double radius_mm) {
  const Vector3d eye = view.color_from_ct->inverse().translation();
  return radius_mm * (eye.normalized() + Vector3d(0.1, 0.2, -0.15)).normalized();
}

TEST(PickPoint, FindsTheSkinOutsideOfTheHole) {
  const auto scene = ball();
  const auto closed = view(0.0F);
  const Vector3d truth = front(closed, kSkinMm);
  const auto picked = pick_point(scene, closed, pixel_of(closed, truth));
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->thing, PickedThing::kSkin);
  EXPECT_LT((picked->ct_mm - truth).norm(), 0.3);
  const Vector3d to_eye = (closed.color_from_ct->inverse().translation() - truth).normalized();
  EXPECT_NEAR(picked->facing, to_eye.dot(truth.normalized()), 0.05);
}

TEST(PickPoint, FindsTheStructureInTheHole) {
  const auto scene = ball();
  auto open = view();
  const Vector3d truth = front(open, kBoneMm);
  const auto picked = pick_point(scene, open, pixel_of(open, truth));
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->thing, PickedThing::kStructure);
  EXPECT_EQ(picked->structure, "bone");
  EXPECT_LT((picked->ct_mm - truth).norm(), 0.3);

  open.structure_opacity["bone"] = 0.0F;
  EXPECT_EQ(pick_point(scene, open, pixel_of(open, truth))->thing, PickedThing::kSkin);
  open.structure_opacity["bone"] = 1.0F;
  open.hole = {.center = {0.1F, 0.1F}, .radius = 0.05F};
  EXPECT_EQ(pick_point(scene, open, pixel_of(open, truth))->thing, PickedThing::kSkin);
}

TEST(PickPoint, FindsTheSliceAndWhatStandsInFrontOfIt) {
  const auto scene = ball();
  auto sliced = view();
  sliced.slice = {.plane = SlicePlane::kCamera, .depth_mm = 40.0F};
  // The middle of the hole: the skin there is 60 mm before the centre, more or less.
  const auto picked = pick_point(scene, sliced, {320.0, 239.0});
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->thing, PickedThing::kSlice);
  const Vector3d in_camera = *sliced.color_from_ct * picked->ct_mm;
  auto closed = view(0.0F);
  const Vector3d skin = *closed.color_from_ct * pick_point(scene, closed, {320.0, 239.0})->ct_mm;
  EXPECT_NEAR(in_camera.z(), skin.z() + 40.0, 1e-6);
  EXPECT_LT((kCamera.project(in_camera).value() - Eigen::Vector2d(320.0, 239.0)).norm(), 1e-3);

  sliced.slice.cuts = false;  // The front of the bone is 10 mm before the slice.
  EXPECT_EQ(pick_point(scene, sliced, {320.0, 239.0})->thing, PickedThing::kStructure);
  sliced.slice.opacity = 0.0F;
  sliced.structure_opacity["bone"] = 0.0F;
  EXPECT_EQ(pick_point(scene, sliced, {320.0, 239.0})->thing, PickedThing::kSkin);
}

TEST(PickPoint, FindsOnlySkinWhereTheCuttingSliceLeavesNothing) {
  const auto scene = ball();
  auto cut = view();
  // From the front, below the plane: what lies on this side of it is cut away.
  cut.color_from_ct = Eigen::Isometry3d(Eigen::AngleAxisd(M_PI / 2.0, Vector3d::UnitX()));
  cut.color_from_ct->pretranslate(Vector3d(0, 0, 500));
  cut.slice = {.plane = SlicePlane::kAxial, .position = 0.8F};
  for (const double z_mm : {0.0, -10.0}) {  // A ray beside the plane, and one away from it.
    const auto pixel = pixel_of(cut, {0.0, 0.0, z_mm});
    cut.slice.cuts = true;
    EXPECT_EQ(pick_point(scene, cut, pixel)->thing, PickedThing::kSkin);
    cut.slice.cuts = false;
    EXPECT_EQ(pick_point(scene, cut, pixel)->thing, PickedThing::kStructure);
  }
}

TEST(PickPoint, FindsWhereTheVolumeIsDense) {
  const auto scene = ball();
  auto volumed = view();
  volumed.structure_opacity["bone"] = 0.0F;
  volumed.volume = {.preset = VolumePreset::kBone, .level_hu = 400.0F, .window_hu = 1000.0F};
  const Vector3d truth = front(volumed, 45.0);
  const auto picked = pick_point(scene, volumed, pixel_of(volumed, truth));
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->thing, PickedThing::kVolume);
  EXPECT_LT((picked->ct_mm - truth).norm(), 2.0);
}

TEST(PickPoint, HasNothingBesideTheBodyOrWithoutAPose) {
  const auto scene = ball();
  EXPECT_FALSE(pick_point(scene, view(), {3.0, 4.0}));
  EXPECT_FALSE(pick_point(scene, view(), {-20.0, 240.0}));
  EXPECT_FALSE(pick_point(scene, view(), {std::nan(""), 240.0}));
  auto lost = view();
  lost.color_from_ct.reset();
  EXPECT_FALSE(pick_point(scene, lost, {320.0, 240.0}));
}

}  // namespace
}  // namespace mor
