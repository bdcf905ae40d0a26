// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/kinect_noise.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace mor::internal {
namespace {

constexpr double kFocalPx = 525.0;

IdealDepth wall(float z_mm, std::uint8_t facing = 255) {
  return {Image<float>(320, 240, z_mm), Image<std::uint8_t>(320, 240, facing)};
}

/// A wall that leans by some disparity steps across the picture: readings meet every phase of one.
IdealDepth leaning_wall(float z_mm, std::uint8_t facing) {
  auto scene = wall(z_mm, facing);
  const auto lean_mm = static_cast<float>(4.0 * kinect::depth_step_mm(z_mm));
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      scene.z_mm(x, y) += lean_mm * (static_cast<float>(x) / 319.0F - 0.5F);
    }
  }
  return scene;
}

struct Spread {
  double bias_mm = 0.0;
  double sd_mm = 0.0;
  double share_read = 0.0;
};

Spread spread_of(const Image<std::uint16_t>& seen_mm, const IdealDepth& scene) {
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < seen_mm.size(); ++i) {
    if (seen_mm.data()[i] == 0) continue;
    const double error_mm = seen_mm.data()[i] - static_cast<double>(scene.z_mm.data()[i]);
    sum += error_mm;
    squares += error_mm * error_mm;
    ++count;
  }
  const double mean = sum / count;
  return {
      mean, std::sqrt(squares / count - mean * mean), count / static_cast<double>(seen_mm.size())};
}

TEST(KinectNoise, SpreadsDepthAsNguyenMeasuredIt) {
  const KinectNoise noise(kFocalPx, 3);
  for (const double angle_rad : {0.0, 0.5, 1.1}) {
    for (const float z_mm : {600.0F, 700.0F, 1000.0F, 1500.0F, 2500.0F}) {
      const auto facing = static_cast<std::uint8_t>(std::lround(255.0 * std::cos(angle_rad)));
      const auto scene = leaning_wall(z_mm, facing);
      const auto spread = spread_of(noise.apply(scene, 0), scene);
      const double expected_mm = kinect::axial_sd_mm(z_mm, angle_rad);
      EXPECT_NEAR(spread.sd_mm / expected_mm, 1.0, 0.1) << z_mm << ' ' << angle_rad;
      EXPECT_NEAR(spread.bias_mm, 0.0, 0.1 * expected_mm) << z_mm;
      EXPECT_GT(spread.share_read, 0.99);
    }
  }
}

TEST(KinectNoise, FollowsThePublishedFormulas) {
  EXPECT_NEAR(kinect::axial_sd_mm(400.0, 0.0), 1.2, 1e-9);
  EXPECT_NEAR(kinect::axial_sd_mm(1400.0, 0.0), 3.1, 1e-9);
  EXPECT_NEAR(kinect::lateral_sd_px(0.0), 0.8, 1e-9);
  EXPECT_NEAR(kinect::lateral_sd_px(std::numbers::pi / 4.0), 0.835, 1e-9);
  // Khoshelham and Elberink report steps of about 7 cm at 5 m.
  EXPECT_NEAR(kinect::depth_step_mm(5000.0), 70.0, 5.0);
}

TEST(KinectNoise, ReadsOnlyTheDepthsOfEighthsOfADisparityPixel) {
  const KinectNoise noise(kFocalPx, 3);
  const auto seen = noise.apply(wall(3000.0F), 0);
  std::set<int> depths;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen.data()[i] > 0) depths.insert(seen.data()[i]);
  }
  ASSERT_GT(depths.size(), 2U);
  for (const int z_mm : depths) {
    const double steps =
        kinect::kInfraredFocalPx * kinect::kBaselineMm / kinect::kDisparityStepPx / z_mm;
    // Whole millimetres blur the disparity by half a millimetre's worth.
    EXPECT_NEAR(steps, std::round(steps), 0.51 / kinect::depth_step_mm(z_mm)) << z_mm;
  }
  for (auto next = std::next(depths.begin()); next != depths.end(); ++next) {
    EXPECT_NEAR(*next - *std::prev(next), kinect::depth_step_mm(*next), 2.0);
  }
}

TEST(KinectNoise, ShadowLiesLeftOfWhatCastsItForTheProjectorStandsOnTheRight) {
  auto scene = wall(1000.0F);
  for (int y = 0; y < 240; ++y) {
    for (int x = 150; x < 200; ++x) scene.z_mm(x, y) = 600.0F;
  }
  const auto seen = KinectNoise(kFocalPx, 3).apply(scene, 0);
  const double width_px = kFocalPx * kinect::kBaselineMm * (1.0 / 600.0 - 1.0 / 1000.0);  // 26 px.
  const auto share_read = [&](int from, int to) {
    double count = 0.0;
    for (int y = 0; y < 240; ++y) {
      for (int x = from; x < to; ++x) count += seen(x, y) > 0 ? 1.0 : 0.0;
    }
    return count / (240.0 * (to - from));
  };
  EXPECT_EQ(share_read(150 - static_cast<int>(width_px) + 1, 149), 0.0);
  EXPECT_GT(share_read(150 - static_cast<int>(width_px) - 12, 150 - static_cast<int>(width_px) - 4),
            0.97);
  EXPECT_GT(share_read(204, 260), 0.97);
  EXPECT_GT(share_read(156, 194), 0.97);
}

TEST(KinectNoise, LosesReadingsAtGrazingAnglesAndAtEdges) {
  const KinectNoise noise(kFocalPx, 3);
  const auto share = [&](double angle_deg) {
    const double cosine = std::cos(angle_deg * std::numbers::pi / 180.0);
    const auto scene = wall(700.0F, static_cast<std::uint8_t>(255.0 * cosine));
    return spread_of(noise.apply(scene, 0), scene).share_read;
  };
  EXPECT_GT(share(60.0), 0.99);
  EXPECT_LT(share(80.0), 0.75);
  EXPECT_LT(share(88.0), 0.05);
  auto step = wall(1000.0F);
  for (int y = 0; y < 240; ++y) {
    for (int x = 160; x < 320; ++x) step.z_mm(x, y) = 1400.0F;
  }
  const auto seen = noise.apply(step, 0);
  int num_read = 0;
  for (int y = 0; y < 240; ++y) num_read += seen(160, y) > 0 ? 1 : 0;
  EXPECT_LT(num_read, 220);
  EXPECT_GT(num_read, 100);
}

TEST(KinectNoise, ReadsNothingOutsideItsRangeNorWhereThereIsNothing) {
  const KinectNoise noise(kFocalPx, 3);
  for (const float z_mm : {0.0F, 1.0F, 300.0F, 5000.0F, 1e6F, 1e30F}) {
    const auto seen = noise.apply(wall(z_mm), 0);
    for (std::size_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen.data()[i], 0) << z_mm;
  }
}

TEST(KinectNoise, DependsOnSeedAndFrameAndOnNothingElse) {
  const auto scene = wall(800.0F);
  const KinectNoise noise(kFocalPx, 3);
  const auto first = noise.apply(scene, 5);
  EXPECT_FALSE(noise.apply(scene, 6) == first);
  EXPECT_EQ(noise.apply(scene, 5), first);
  EXPECT_EQ(KinectNoise(kFocalPx, 3).apply(scene, 5), first);
  EXPECT_FALSE(KinectNoise(kFocalPx, 4).apply(scene, 5) == first);
}

}  // namespace
}  // namespace mor::internal
