// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/exposure.h"

#include <gtest/gtest.h>

namespace mor::internal {
namespace {

TEST(Exposure, SwingsWithinWhatWasAskedAndDiffersByChannel) {
  constexpr double kSwing = 0.4;
  float least = 1.0F;
  float most = 0.0F;
  float apart = 0.0F;
  for (std::uint64_t frame = 0; frame < 3000; ++frame) {
    const auto gains = exposure_gains(kSwing, 7, frame, static_cast<double>(frame) / 30.0);
    least = std::min(least, gains.minCoeff());
    most = std::max(most, gains.maxCoeff());
    apart = std::max(apart, gains.maxCoeff() - gains.minCoeff());
  }
  EXPECT_GE(least, 1.0F - kSwing);
  EXPECT_LE(most, 1.0F);
  EXPECT_GT(most - least, 0.5 * kSwing);
  EXPECT_GT(apart, 0.1 * kSwing);
  EXPECT_EQ(exposure_gains(0.0, 7, 3, 0.1), Eigen::Vector3f::Ones());
}

TEST(Exposure, MultipliesEachChannel) {
  Image<Rgb8> color(2, 1, {200, 100, 50});
  expose(color, {0.5F, 1.0F, 0.8F});
  EXPECT_EQ(color(1, 0), (Rgb8{100, 100, 40}));
}

}  // namespace
}  // namespace mor::internal
