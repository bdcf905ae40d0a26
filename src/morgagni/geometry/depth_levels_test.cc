// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/depth_levels.h"

#include <cmath>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/image_png.h"

namespace mor {
namespace {

using DepthImage = Image<std::uint16_t>;

double rounded(double mm) {
  return std::round(mm);
}
double cut_off(double mm) {
  return std::floor(mm);
}

/// A slope from `near_mm` to `far_mm` with noise, told in steps of 1 / k and whole millimetres.
DepthImage slope(
    double near_mm, double far_mm, double k, double offset, double (*whole)(double) = rounded) {
  DepthImage image(640, 480);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise_mm(0.0, 1.5);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double mm = near_mm + (far_mm - near_mm) * y / image.height() + noise_mm(random);
      const double step = std::round(k / mm - offset);
      image(x, y) = static_cast<std::uint16_t>(whole(k / (step + offset)));
    }
  }
  return image;
}

/// How far the levels are from the depths of the steps, at worst.
double worst_mm(const DepthLevels& levels, double near_mm, double far_mm, double k, double offset) {
  double worst = 0.0;
  for (double step = std::ceil(k / far_mm); k / (step + offset) > near_mm; step += 1.0) {
    const double mm = k / (step + offset);
    worst = std::max(worst, std::abs(levels.mm(static_cast<std::uint16_t>(std::lround(mm))) - mm));
  }
  return worst;
}

TEST(DepthLevels, FindsTheDepthsBeforeRounding) {
  for (const double k : {348e3, 320e3, 211e3, 680e3}) {
    for (const double offset : {0.0, 0.37, 0.8}) {
      DepthLevels levels;
      levels.learn(slope(650.0, 1400.0, k, offset).view());
      ASSERT_TRUE(levels.has_steps()) << k << " " << offset;
      // Nearer than a step of a millimetre a value holds several depths.
      EXPECT_LT(worst_mm(levels, std::max(660.0, std::sqrt(1.2 * k)), 1390.0, k, offset), 0.05)
          << k << " " << offset;
    }
  }
}

TEST(DepthLevels, FindsTheDepthsWhoseFractionsWereCutOff) {
  // As a real Kinect's (Andy Zeng's TSDF demo) are.
  constexpr double kK = 345.3e3;
  DepthLevels levels;
  levels.learn(slope(900.0, 2400.0, kK, 0.85, cut_off).view());
  ASSERT_TRUE(levels.has_steps());
  for (double step = 150.0; step < 380.0; step += 1.0) {
    const double mm = kK / (step + 0.85);
    EXPECT_NEAR(levels.mm(static_cast<std::uint16_t>(mm)), mm, 0.05);
  }
}

TEST(DepthLevels, FindsTheStepsOfARealKinect) {
  const auto folder = std::filesystem::path(MORGAGNI_DATA_DIR) / "rgbd_tsdf_demo" / "frames";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data folder at " << folder;
  for (const int number : {150, 174}) {
    const auto depth = read_png_gray16(folder / fmt::format("frame-{:06}.depth.png", number));
    ASSERT_TRUE(depth) << depth.error().message;
    DepthLevels levels;
    levels.learn(depth->view());
    ASSERT_TRUE(levels.has_steps()) << number;
    // Of all frames the same: they come from the sensor, not from what it looks at.
    EXPECT_NEAR(levels.mm(1204), 1204.2, 0.05);
    EXPECT_NEAR(levels.mm(1243), 1243.2, 0.05);
  }
}

TEST(DepthLevels, KeepsEveryValueWithinHalfAMillimetre) {
  DepthLevels levels;
  levels.learn(slope(650.0, 1400.0, 348e3, 0.2).view());
  ASSERT_TRUE(levels.has_steps());
  for (int value = 0; value <= 65535; ++value) {
    ASSERT_NEAR(levels.mm(static_cast<std::uint16_t>(value)), value, 0.5001);
  }
  EXPECT_EQ(levels.mm(0), 0.0F);
}

TEST(DepthLevels, LeavesASensorWithoutStepsAlone) {
  DepthImage image(640, 480);
  std::mt19937_64 random(2);
  std::normal_distribution<double> noise_mm(0.0, 1.5);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image(x, y) = static_cast<std::uint16_t>(std::lround(700.0 + y + noise_mm(random)));
    }
  }
  DepthLevels levels;
  levels.learn(image.view());
  EXPECT_FALSE(levels.has_steps());
  EXPECT_EQ(levels.mm(811), 811.0F);
}

TEST(DepthLevels, FindsNoStepsInSparseValuesThatFollowNone) {
  // As many values as a Kinect has, at random places.
  DepthImage image(640, 480);
  std::mt19937_64 random(3);
  std::vector<std::uint16_t> values;
  for (int i = 0; i < 300; ++i) values.push_back(static_cast<std::uint16_t>(650 + random() % 750));
  for (int i = 0; i < 640 * 480; ++i) {
    image(i % 640, i / 640) = values[static_cast<std::size_t>(i) % values.size()];
  }
  DepthLevels levels;
  levels.learn(image.view());
  EXPECT_FALSE(levels.has_steps());
}

TEST(DepthLevels, FindsNoneInAFewValues) {
  DepthLevels levels;
  levels.learn(slope(800.0, 820.0, 348e3, 0.0).view());
  EXPECT_FALSE(levels.has_steps());
  // A later picture with more of them tells.
  levels.learn(slope(650.0, 1400.0, 348e3, 0.0).view());
  EXPECT_TRUE(levels.has_steps());
}

}  // namespace
}  // namespace mor
