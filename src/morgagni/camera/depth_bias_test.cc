// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/depth_bias.h"

#include <cmath>

#include <gtest/gtest.h>

namespace mor::internal {
namespace {

Image<float> errors_mm(const DepthBias& bias, float z_mm) {
  Image<float> seen(160, 120, z_mm);
  bias.apply(seen);
  for (std::size_t i = 0; i < seen.size(); ++i) seen.data()[i] -= z_mm;
  return seen;
}

double rms(const Image<float>& values) {
  double squares = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    squares += static_cast<double>(values.data()[i]) * static_cast<double>(values.data()[i]);
  }
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(DepthBias, HasTheAmplitudeAskedForAndGrowsWithDistance) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const DepthBias bias(160, 120, 3.0, seed);
    EXPECT_NEAR(rms(errors_mm(bias, 800.0F)), 3.0, 0.01) << seed;
    EXPECT_NEAR(rms(errors_mm(bias, 1600.0F)), 6.0, 0.02) << seed;
  }
}

TEST(DepthBias, IsSmoothAndDiffersBySeed) {
  const auto errors = errors_mm(DepthBias(160, 120, 3.0, 1), 800.0F);
  for (int y = 1; y < 120; ++y) {
    for (int x = 1; x < 160; ++x) {
      ASSERT_LT(std::abs(errors(x, y) - errors(x - 1, y)), 0.4F);
      ASSERT_LT(std::abs(errors(x, y) - errors(x, y - 1)), 0.5F);
    }
  }
  EXPECT_FALSE(errors == errors_mm(DepthBias(160, 120, 3.0, 2), 800.0F));
  EXPECT_TRUE(errors == errors_mm(DepthBias(160, 120, 3.0, 1), 800.0F));
}

TEST(DepthBias, LeavesNoReadingAlone) {
  Image<float> seen(160, 120, 0.0F);
  DepthBias(160, 120, 3.0, 1).apply(seen);
  EXPECT_EQ(rms(seen), 0.0);
}

}  // namespace
}  // namespace mor::internal
