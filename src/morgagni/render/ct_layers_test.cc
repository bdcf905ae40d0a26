// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Slices and volume rendering against what is known of the voxels.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/render/internal/ray_caster.h"
#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{321, 239, 270.0, 268.0, 158.0, 121.0, {0.05, -0.08, 0, 0, 0}};
constexpr int kSize = 120;
/// Of the grey picture's 100, in a hole with nothing inside.
constexpr int kOpen = 50;

Image<Rgb8> gray() {
  return {kCamera.width_px, kCamera.height_px, Rgb8{100, 100, 100}};
}

OverlayView everywhere(const Eigen::Isometry3d& pose) {
  return {.color_camera = kCamera,
          .color_from_ct = pose,
          .opacity = 1.0F,
          .hole = {.radius = 2.0F},
          .is_still = true};
}

/// From the front and above: all three planes of the body are seen at an angle.
Eigen::Isometry3d oblique() {
  Eigen::Isometry3d pose = testing::at(5.0, -8.0, 260.0);
  pose.linear() = (Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  return pose;
}

double ramp_hu(const Eigen::Vector3d& p) {
  return 2.0 * p.x() - 1.5 * p.y() + 3.0 * p.z() + 40.0;
}

class SliceTest : public ::testing::TestWithParam<SlicePlane> {};

TEST_P(SliceTest, ShowsTheVoxelsWhereTheyAre) {
  const auto renderer = testing::make_renderer({.volume = testing::make_volume(kSize, ramp_hu)});
  OverlayView view = everywhere(oblique());
  view.slice = {.plane = GetParam(), .position = 0.4F, .depth_mm = 70.0F, .window_hu = 900.0F};
  const auto picture = testing::rendered(*renderer, gray(), view);

  const double half = 0.5 * (kSize - 1);
  const double place = -half + 0.4 * 2.0 * half;
  const Eigen::Isometry3d ct_from_color = view.color_from_ct->inverse();
  // Without a skin the camera's plane counts from the volume's nearest corner.
  double nearest = 1e9;
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      for (const double z : {-half, half}) {
        nearest = std::min(nearest, (*view.color_from_ct * Eigen::Vector3d(x, y, z)).z());
      }
    }
  }
  const int axis = GetParam() == SlicePlane::kAxial     ? 2
                   : GetParam() == SlicePlane::kCoronal ? 1
                                                        : 0;
  int num_seen = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Eigen::Vector3d direction = kCamera.ray(Eigen::Vector2d(x, y)).homogeneous();
      const Eigen::Vector3d eye = ct_from_color.translation();
      const Eigen::Vector3d ray = ct_from_color.linear() * direction;
      const double z =
          GetParam() == SlicePlane::kCamera ? nearest + 70.0 : (place - eye[axis]) / ray[axis];
      const Eigen::Vector3d p = eye + z * ray;
      const double outside = (p.cwiseAbs().array() - half).maxCoeff();
      if (z > 0.0 && outside < -0.1) {
        const double truth = std::clamp((ramp_hu(p) - 40.0) / 900.0 + 0.5, 0.0, 1.0) * 255.0;
        ASSERT_NEAR(picture(x, y).r, truth, 1.0) << x << ", " << y;
        ++num_seen;
      } else if (z < 0.0 || outside > 0.1) {
        ASSERT_EQ(picture(x, y).r, kOpen) << x << ", " << y;
      }
    }
  }
  EXPECT_GT(num_seen, 3000);
}

INSTANTIATE_TEST_SUITE_P(Planes,
                         SliceTest,
                         ::testing::Values(SlicePlane::kAxial,
                                           SlicePlane::kCoronal,
                                           SlicePlane::kSagittal,
                                           SlicePlane::kCamera));

TEST(Slice, AnInvertedWindowGoesFromWhiteToBlack) {
  const auto renderer = testing::make_renderer({.volume = testing::make_volume(kSize, ramp_hu)});
  OverlayView view = everywhere(testing::at(0.0, 0.0, 300.0));
  view.slice = {.plane = SlicePlane::kCamera, .depth_mm = 60.0F, .window_hu = 700.0F};
  const auto upright = testing::rendered(*renderer, gray(), view);
  view.slice.window_hu = -700.0F;
  const auto inverted = testing::rendered(*renderer, gray(), view);
  for (const int x : {130, 158, 190}) {
    EXPECT_NEAR(upright(x, 121).r, 255 - inverted(x, 121).r, 1);
  }
}

TEST(Slice, ShowsNothingBesideTheBody) {
  const auto ball = testing::make_volume(kSize, [](const Eigen::Vector3d& p) {
    return p.norm() < 45.0 ? 40.0 : static_cast<double>(kOutsideHu);
  });
  const auto renderer = testing::make_renderer({.volume = ball});
  OverlayView view = everywhere(testing::at(0.0, 0.0, 300.0));
  view.slice = {.plane = SlicePlane::kCoronal, .position = 0.5F, .window_hu = 100.0F};
  view.color_from_ct->linear() =
      Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto picture = testing::rendered(*renderer, gray(), view);
  EXPECT_NEAR(picture(158, 121).r, 128, 1);
  const int edge_px = static_cast<int>(45.0 * 270.0 / 300.0);
  EXPECT_NEAR(picture(158 + edge_px - 3, 121).r, 128, 1);
  EXPECT_EQ(picture(158 + edge_px + 3, 121).r, kOpen);
}

TEST(Slice, CutsAwayWhatIsBeforeIt) {
  const RenderedStructure ball{"ball", testing::make_sphere({0, 0, 0}, 40.0, 40), {1, 0, 0}};
  const auto solid = testing::make_volume(kSize, [](const Eigen::Vector3d&) { return 40.0; });
  const auto renderer = testing::make_renderer({.structures = {ball}, .volume = solid});
  OverlayView view = everywhere(testing::at(0.0, 0.0, 300.0));
  const double front_mm = 300.0 - 0.5 * (kSize - 1);
  view.slice = {.plane = SlicePlane::kCamera,
                .depth_mm = static_cast<float>(300.0 - front_mm),
                .window_hu = 100.0F};
  EXPECT_NEAR(testing::rendered(*renderer, gray(), view)(158, 121).g, 128, 1) << "the slice";
  view.slice.cuts = false;
  EXPECT_EQ(testing::rendered(*renderer, gray(), view)(158, 121).g, 0) << "the ball before it";
  view.slice.cuts = true;
  view.slice.opacity = 0.0F;
  const auto opened = testing::rendered(*renderer, gray(), view);
  EXPECT_EQ(opened(158, 121).g, 0) << "the far half of the ball, from inside";
  EXPECT_GT(opened(158, 121).r, 20);
}

TEST(Transparency, TheNearerIsInFrontWhateverTheOrder) {
  const RenderedStructure red{"red", testing::make_sphere({0, 0, -40}, 30.0, 40), {1, 0, 0}};
  const RenderedStructure green{"green", testing::make_sphere({0, 0, 40}, 30.0, 40), {0, 1, 0}};
  for (const auto& structures : {std::vector{red, green}, std::vector{green, red}}) {
    const auto renderer = testing::make_renderer({.structures = structures});
    OverlayView view = everywhere(testing::at(0.0, 0.0, 400.0));
    const auto color_at = [&](float red_opacity, float green_opacity) {
      view.structure_opacity = {{"red", red_opacity}, {"green", green_opacity}};
      return testing::rendered(*renderer, gray(), view)(158, 121);
    };
    const Rgba8 only_red = color_at(1.0F, 0.0F);
    const Rgba8 only_green = color_at(0.0F, 1.0F);
    EXPECT_EQ(color_at(1.0F, 0.5F), only_red) << "the far one is behind an opaque one";
    const Rgba8 half = color_at(0.5F, 1.0F);
    EXPECT_NEAR(half.r, only_red.r / 2, 2);
    EXPECT_NEAR(half.g, only_green.g / 2, 2);
    const Rgba8 both = color_at(0.5F, 0.5F);
    EXPECT_NEAR(both.g, only_green.g / 4 + 50 / 4, 2)
        << "a quarter of the darkened picture is left";
  }
}

/// HU at a place in voxels, at the border as if it went on.
double interpolated_hu(const Volume& volume, const Eigen::Array3d& place) {
  const Eigen::Array3d last(volume.size[0] - 1, volume.size[1] - 1, volume.size[2] - 1);
  const Eigen::Array3d at = place.max(0.0).min(last - 1e-3);
  const Eigen::Array3i corner = at.cast<int>();
  const Eigen::Array3d share = at - corner.cast<double>();
  double hu = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Array3i side(i & 1, i >> 1 & 1, i >> 2 & 1);
    const Eigen::Array3d weight = (side == 1).select(share, 1.0 - share);
    const Eigen::Array3i voxel = corner + side;
    hu += weight.prod() * volume.hu[volume.index(voxel.x(), voxel.y(), voxel.z())];
  }
  return hu;
}

/// Mean of the opacities of all HU from one to the other.
double mean_opacity(const internal::TransferTable& table, double hu_a, double hu_b) {
  const auto entry = [](double hu) {
    return static_cast<int>(std::clamp(hu, -1024.0, 3071.0) + 1024.0 + 0.5);
  };
  const auto opacity = [&](int i) {
    return static_cast<double>(table.opacity[static_cast<std::size_t>(i)]);
  };
  const auto [low, high] = std::minmax({entry(hu_a), entry(hu_b)});
  if (low == high) return opacity(low);
  double sum = 0.5 * (opacity(low) + opacity(high));
  for (int i = low + 1; i < high; ++i) sum += opacity(i);
  return sum / (high - low);
}

/// The opacity of a ray, by doubles and without leaps.
double brute_force_opacity(const Volume& volume,
                           const internal::TransferTable& table,
                           double step_mm,
                           const Eigen::Isometry3d& color_from_ct,
                           const Eigen::Vector3d& direction) {
  const Eigen::Isometry3d grid_from_color = (color_from_ct * volume.ct_from_grid).inverse();
  const Eigen::Array3d eye = grid_from_color.translation().cwiseQuotient(volume.spacing_mm).array();
  const Eigen::Array3d way =
      (grid_from_color.linear() * direction).cwiseQuotient(volume.spacing_mm).array();
  const Eigen::Array3d last(volume.size[0] - 1, volume.size[1] - 1, volume.size[2] - 1);
  const Eigen::Array3d a = -eye / way;
  const Eigen::Array3d b = (last - eye) / way;
  const double enter = std::max(1.0, a.min(b).maxCoeff());
  const double leave = a.max(b).minCoeff();
  const double step = step_mm / direction.norm();
  double left = 1.0;
  double before = interpolated_hu(volume, eye + (enter - 0.5 * step) * way);
  for (double z = enter + 0.5 * step; z < leave; z += step) {
    const double hu = interpolated_hu(volume, eye + z * way);
    left *= 1.0 - mean_opacity(table, before, hu);
    before = hu;
  }
  return 1.0 - left;
}

TEST(RayCaster, SeesWhatBruteForceSees) {
  // Two balls and a shell, much of it empty, on a grid that is no cube.
  auto volume = std::make_shared<Volume>();
  volume->size = {90, 101, 44};
  volume->spacing_mm = {1.1, 0.9, 2.3};
  volume->ct_from_grid.translation() = Eigen::Vector3d(-50.0, -45.0, -50.0);
  for (int z = 0; z < 44; ++z) {
    for (int y = 0; y < 101; ++y) {
      for (int x = 0; x < 90; ++x) {
        const Eigen::Vector3d p =
            volume->ct_from_grid * Eigen::Vector3d(x, y, z).cwiseProduct(volume->spacing_mm);
        const double ball = 300.0 - 40.0 * ((p - Eigen::Vector3d(20, 10, -15)).norm() - 12.0);
        const double shell = 260.0 - 60.0 * std::abs(p.norm() - 42.0);
        const double hu = std::max({ball, shell, -1000.0});
        volume->hu.push_back(static_cast<std::int16_t>(std::lround(std::min(hu, 600.0))));
      }
    }
  }
  internal::PictureRays rays;
  rays.update(kCamera);
  for (const auto preset :
       {VolumePreset::kBone, VolumePreset::kSoftTissue, VolumePreset::kVessels}) {
    internal::RayCaster caster(volume);
    const auto [level_hu, window_hu] = volume_window(preset);
    caster.set({preset, level_hu, window_hu});
    internal::Layer seen;
    seen.clear({0, 0, kCamera.width_px, kCamera.height_px});
    caster.cast({.rays = &rays, .color_from_ct = oblique()}, seen);
    int num_seen = 0;
    int num_off = 0;
    for (int y = 0; y < kCamera.height_px; y += 3) {
      for (int x = 0; x < kCamera.width_px; x += 3) {
        const Eigen::Vector3d direction = kCamera.ray(Eigen::Vector2d(x, y)).homogeneous();
        const double truth =
            brute_force_opacity(*volume, caster.table(), caster.step_mm(), oblique(), direction);
        const double found = seen.row(y)[x].a / 255.0;
        // A ray that is cut off at 98 % has no more than 2 % left; a HU's rounding may fall
        // either way.
        if (std::abs(found - truth) > 0.03) ++num_off;
        if (truth > 0.05) ++num_seen;
      }
    }
    EXPECT_GT(num_seen, 500);
    EXPECT_EQ(num_off, 0) << to_string(preset);
  }
}

TEST(RayCaster, AHomogeneousBlockHoldsBackWhatItsThicknessSays) {
  constexpr int kSide = 60;
  const auto block = testing::make_volume(kSide, [](const Eigen::Vector3d&) { return 40.0; });
  internal::PictureRays rays;
  const PinholeCamera camera{9, 9, 5000.0, 5000.0, 4.0, 4.0, {}};
  rays.update(camera);
  internal::RayCaster caster(block);
  caster.set({VolumePreset::kSoftTissue, 40.0F, 400.0F});
  internal::Layer seen;
  seen.clear({0, 0, 9, 9});
  caster.cast({.rays = &rays, .color_from_ct = testing::at(0, 0, 500.0)}, seen);
  const auto points = transfer_points(VolumePreset::kSoftTissue);
  const auto below = std::find_if(
      points.begin(), points.end(), [](const TransferPoint& point) { return point.hu > 40.0F; });
  const TransferPoint& low = *(below - 1);
  const double per_mm =
      std::lerp(low.opacity_per_mm, below->opacity_per_mm, (40.0 - low.hu) / (below->hu - low.hu));
  EXPECT_NEAR(seen.row(4)[4].a / 255.0, 1.0 - std::pow(1.0 - per_mm, kSide - 1), 0.01);
}

TEST(RayCaster, ABallsOutlineIsRightToHalfAPixel) {
  constexpr double kRadiusMm = 40.0;
  // Bone begins to be seen at 130 HU; over a voxel the flanks are straight.
  const auto ball = testing::make_volume(kSize, [](const Eigen::Vector3d& p) {
    return std::clamp(130.0 - 400.0 * (p.norm() - kRadiusMm), -1000.0, 1500.0);
  });
  const auto renderer = testing::make_renderer({.volume = ball});
  const Eigen::Vector3d center(12.0, -9.0, 260.0);
  OverlayView view = everywhere(testing::at(center.x(), center.y(), center.z()));
  const auto [level_hu, window_hu] = volume_window(VolumePreset::kBone);
  view.volume = {VolumePreset::kBone, level_hu, window_hu};
  const auto picture = testing::rendered(*renderer, gray(), view);
  const double half_px_mm = 0.5 * center.norm() / kCamera.focal_y_px;
  int num_wrong = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Eigen::Vector3d ray = kCamera.ray(Eigen::Vector2d(x, y)).homogeneous().normalized();
      const double beside_mm = (center - ray * ray.dot(center)).norm();
      const bool is_untouched = picture(x, y) == Rgba8{kOpen, kOpen, kOpen, 255};
      if (beside_mm < kRadiusMm - half_px_mm - 0.2 && is_untouched) ++num_wrong;
      if (beside_mm > kRadiusMm + half_px_mm + 0.2 && !is_untouched) ++num_wrong;
    }
  }
  EXPECT_EQ(num_wrong, 0);
}

TEST(RayCaster, ASurfaceBehindTheVolumeIsSeenThroughItAndOneBeforeItIsNot) {
  const auto fog = testing::make_volume(60, [](const Eigen::Vector3d&) { return 40.0; });
  for (const double z : {-40.0, 40.0}) {
    const RenderedStructure ball{"ball", testing::make_sphere({0, 0, z}, 5.0, 30), {0, 0, 1}};
    const auto renderer = testing::make_renderer({.structures = {ball}, .volume = fog});
    OverlayView view = everywhere(testing::at(0, 0, 400.0));
    const int alone = testing::rendered(*renderer, gray(), view)(158, 121).b;
    view.volume = {VolumePreset::kSoftTissue, 40.0F, 400.0F};
    const Rgba8 both = testing::rendered(*renderer, gray(), view)(158, 121);
    if (z < 0.0) {
      EXPECT_NEAR(both.b, alone, 2) << "the opaque ball is before the fog";
      EXPECT_EQ(both.r, 0);
    } else {
      EXPECT_GT(both.r, 60) << "the fog is before the ball";
    }
  }
}

TEST(RayCaster, AMovingPictureIsCoarserButTheSame) {
  const auto ball = testing::make_volume(
      kSize, [](const Eigen::Vector3d& p) { return p.norm() < 50.0 ? 600.0 : -1000.0; });
  const auto renderer = testing::make_renderer({.volume = ball});
  const PinholeCamera camera{1281, 959, 1080.0, 1080.0, 640.0, 479.0, {}};
  const Image<Rgb8> color(camera.width_px, camera.height_px, Rgb8{100, 100, 100});
  OverlayView view = everywhere(testing::at(0, 0, 300.0));
  view.color_camera = camera;
  view.volume = {VolumePreset::kBone, 400.0F, 1000.0F};
  const auto still = testing::rendered(*renderer, color, view);
  view.is_still = false;
  const auto moving = testing::rendered(*renderer, color, view);
  double sum = 0.0;
  for (std::size_t i = 0; i < still.size(); ++i) {
    sum += std::abs(still.data()[i].g - moving.data()[i].g);
  }
  EXPECT_GT(sum, 0.0) << "not every pixel has a ray";
  EXPECT_LT(sum / static_cast<double>(still.size()), 2.0);
}

TEST(RayCaster, RefusesWhatCannotBeInterpolated) {
  auto flat = std::make_shared<Volume>();
  flat->size = {4, 4, 1};
  flat->hu.resize(16);
  const auto refused = OverlayRenderer::create({.volume = flat});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("two voxels a side, got 4 x 4 x 1"));
}

}  // namespace
}  // namespace mor
