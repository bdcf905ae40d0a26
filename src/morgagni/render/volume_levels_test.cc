// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The coarser copies of the volume, and what they are for: far away and while the camera moves, a
// volume neither glitters nor costs more than it has to.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "morgagni/render/internal/ray_caster.h"
#include "morgagni/render/internal/view_grid.h"
#include "morgagni/render/internal/volume_pyramid.h"
#include "morgagni/render/testing/pictures.h"
#include "morgagni/render/testing/shapes.h"

namespace mor {
namespace {

std::shared_ptr<Volume> ramp(const std::array<int, 3>& size, const Eigen::Vector3d& spacing_mm) {
  auto volume = std::make_shared<Volume>();
  volume->size = size;
  volume->spacing_mm = spacing_mm;
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x) {
        const Eigen::Vector3d p = Eigen::Vector3d(x, y, z).cwiseProduct(spacing_mm);
        volume->hu.push_back(
            static_cast<std::int16_t>(std::lround(p.dot(Eigen::Vector3d(8, 12, 4)))));
      }
    }
  }
  return volume;
}

TEST(VolumePyramid, ARampStaysWhereItIs) {
  const auto levels = internal::make_volume_pyramid(ramp({40, 33, 26}, {1.0, 1.0, 1.0}), 3);
  ASSERT_EQ(levels.size(), 3U);
  for (const auto& level : levels) {
    ASSERT_EQ(level->num_voxels(), level->index(0, 0, level->size[2]));
    for (int z = 1; z + 2 < level->size[2]; ++z) {
      for (int y = 1; y + 2 < level->size[1]; ++y) {
        for (int x = 1; x + 2 < level->size[0]; ++x) {
          const Eigen::Vector3d p = Eigen::Vector3d(x, y, z).cwiseProduct(level->spacing_mm);
          ASSERT_NEAR(level->hu[level->index(x, y, z)], p.dot(Eigen::Vector3d(8, 12, 4)), 1.0);
        }
      }
    }
  }
}

TEST(VolumePyramid, NothingOfTheVolumeIsLostAtItsEnds) {
  for (const int size : {32, 33}) {
    const auto levels = internal::make_volume_pyramid(ramp({size, size, size}, {1, 1, 1}), 3);
    for (const auto& level : levels) {
      EXPECT_GE((level->size[0] - 1) * level->spacing_mm.x(), size - 1) << size;
    }
  }
}

TEST(VolumePyramid, ThickSlicesAreKeptUntilTheOthersAreAsThick) {
  const auto levels = internal::make_volume_pyramid(ramp({64, 64, 30}, {0.7, 0.7, 2.0}), 3);
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels[1]->size, (std::array<int, 3>{33, 33, 30}));
  EXPECT_EQ(levels[2]->size, (std::array<int, 3>{17, 17, 16}));
}

TEST(ViewGrid, KnowsTheBodysFarSide) {
  constexpr double kRadiusMm = 90.0;
  const PinholeCamera camera{320, 240, 260.0, 260.0, 159.5, 119.5, {}};
  const Eigen::Vector3d center(20.0, -10.0, 500.0);
  const auto ball = testing::make_sphere(Eigen::Vector3d::Zero(), kRadiusMm, 60);
  internal::ViewGrid grid;
  grid.update(camera, ball, testing::at(center.x(), center.y(), center.z()));
  grid.update_back(ball, testing::at(center.x(), center.y(), center.z()));
  int num_seen = 0;
  for (int y = 4; y < 236; y += 5) {
    for (int x = 4; x < 316; x += 5) {
      const Eigen::Vector3d ray = camera.ray(Eigen::Vector2d(x, y)).homogeneous().normalized();
      const double along = ray.dot(center);
      const double half_sq = kRadiusMm * kRadiusMm - (center - along * ray).squaredNorm();
      const float back_mm = grid.back_at(ray.head<2>().cast<float>() / static_cast<float>(ray.z()));
      if (half_sq < -900.0) EXPECT_EQ(back_mm, 0.0F) << x << ", " << y;
      if (half_sq < 2500.0) continue;  // At the outline a pixel is many mm deep.
      EXPECT_NEAR(back_mm, (along + std::sqrt(half_sq)) * ray.z(), 2.0) << x << ", " << y;
      ++num_seen;
    }
  }
  EXPECT_GT(num_seen, 100);
}

/// Bone with holes the size of a voxel: what aliases most.
std::shared_ptr<const Volume> spongy_bone() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> hu(-100.0, 900.0);
  return testing::make_volume(128, [&](const Eigen::Vector3d& p) {
    return p.norm() < 55.0 ? hu(random) : static_cast<double>(kOutsideHu);
  });
}

/// Mean difference of the pictures before and after a move of a third of a pixel.
double glitter(const internal::RayCaster& caster, float ray_spacing) {
  const PinholeCamera camera{160, 120, 160.0, 160.0, 79.5, 59.5, {}};  // 3 mm a pixel.
  internal::PictureRays rays;
  rays.update(camera);
  internal::Layer before;
  before.clear({0, 0, 160, 120});
  internal::Layer after = before;
  caster.cast({.rays = &rays,
               .color_from_ct = testing::at(0, 0, 480.0),
               .ray_spacing = ray_spacing,
               .is_still = false},
              before);
  caster.cast({.rays = &rays,
               .color_from_ct = testing::at(1.0, 0, 480.0),
               .ray_spacing = ray_spacing,
               .is_still = false},
              after);
  double sum = 0.0;
  double seen = 0.0;
  for (std::size_t i = 0; i < before.pixels.size(); ++i) {
    if (before.pixels[i].a < 128) continue;
    sum += std::abs(before.pixels[i].g - after.pixels[i].g);
    seen += 1.0;
  }
  return sum / seen;
}

TEST(RayCaster, AMovingVolumeDoesNotGlitter) {
  internal::RayCaster caster(spongy_bone());
  caster.set({VolumePreset::kBone, 400.0F, 1000.0F});
  const double fine = glitter(caster, 0.0F);
  const double fitting = glitter(caster, 1.0F / 160.0F);
  EXPECT_GT(fine, 10.0) << "single voxels come and go";
  EXPECT_LT(fitting, 0.4 * fine);
}

TEST(RayCaster, ABallIsAsLargeInEveryCopy) {
  const auto ball = testing::make_volume(128, [](const Eigen::Vector3d& p) {
    return std::clamp(380.0 - 250.0 * (p.norm() - 40.0), -1000.0, 1500.0);
  });
  const PinholeCamera camera{160, 120, 320.0, 320.0, 79.5, 59.5, {}};
  internal::PictureRays rays;
  rays.update(camera);
  internal::RayCaster caster(ball);
  caster.set({VolumePreset::kBone, 400.0F, 1000.0F});
  const auto area_px = [&](float ray_spacing) {
    internal::Layer seen;
    seen.clear({0, 0, 160, 120});
    caster.cast(
        {.rays = &rays, .color_from_ct = testing::at(0, 0, 400), .ray_spacing = ray_spacing}, seen);
    double area = 0.0;
    for (const Rgba8& pixel : seen.pixels) area += pixel.a / 255.0;
    return area;
  };
  const double truth_px = 3.14159 * std::pow(40.0 * 320.0 / std::sqrt(400.0 * 400.0 - 1600.0), 2);
  for (const float ray_spacing : {0.0F, 0.006F, 0.012F}) {
    EXPECT_NEAR(std::sqrt(area_px(ray_spacing) / truth_px), 1.0, 0.03) << ray_spacing;
  }
}

TEST(RayCaster, ATiltedBoneIsLitEvenly) {
  // Dense on its outside, spongy below: samples inside must not be lit by what is behind them.
  const Eigen::Vector3d normal = Eigen::Vector3d(0.10, 0.17, -1.0).normalized();
  const auto bone = testing::make_volume(96, [&](const Eigen::Vector3d& p) {
    const double below_mm = -normal.dot(p);
    return below_mm < 1.5 ? 400.0 + 550.0 * below_mm : std::max(1225.0 - 350.0 * below_mm, 250.0);
  });
  const PinholeCamera camera{160, 120, 320.0, 320.0, 79.5, 59.5, {}};
  internal::PictureRays rays;
  rays.update(camera);
  internal::RayCaster caster(bone);
  caster.set({VolumePreset::kBone, 400.0F, 1000.0F});
  internal::Layer seen;
  seen.clear({0, 0, 160, 120});
  caster.cast({.rays = &rays, .color_from_ct = testing::at(0, 0, 400)}, seen);
  double steps = 0.0;
  for (int y = 40; y < 80; ++y) {
    for (int x = 60; x < 100; ++x) {
      ASSERT_GT(seen.row(y)[x].g, 150);
      steps += std::abs(seen.row(y)[x].g - seen.row(y)[x + 1].g) / 1600.0;
    }
  }
  EXPECT_LT(steps, 3.5);
}

}  // namespace
}  // namespace mor
