// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/statistics.h"

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(Quantile, InterpolatesBetweenRanks) {
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(quantile({10.0, 20.0}, 0.95), 19.5);
}

TEST(Quantile, TakesOneSampleOrNone) {
  EXPECT_DOUBLE_EQ(quantile({7.0}, 0.95), 7.0);
  EXPECT_DOUBLE_EQ(quantile({}, 0.5), 0.0);
}

TEST(RootMeanSquare, IsZeroWithoutSamples) {
  EXPECT_DOUBLE_EQ(root_mean_square({3.0, -4.0, 0.0, 0.0}), 2.5);
  EXPECT_DOUBLE_EQ(root_mean_square({}), 0.0);
}

TEST(RollingWindow, ForgetsWhatIsOlderThanItsCapacity) {
  RollingWindow window(3);
  for (const double sample : {100.0, 100.0, 1.0, 2.0, 3.0}) window.add(sample);
  EXPECT_DOUBLE_EQ(window.median(), 2.0);
}

}  // namespace
}  // namespace mor
