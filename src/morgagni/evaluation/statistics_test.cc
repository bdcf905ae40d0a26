// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/statistics.h"

#include <cmath>

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(Quantile, InterpolatesBetweenNeighbours) {
  EXPECT_DOUBLE_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.95), 9.5);
  EXPECT_DOUBLE_EQ(quantile({5.0, 7.0}, 0.0), 5.0);
  EXPECT_DOUBLE_EQ(quantile({5.0, 7.0}, 1.0), 7.0);
}

TEST(Quantile, TakesOneValueAndNone) {
  EXPECT_DOUBLE_EQ(quantile({8.0}, 0.95), 8.0);
  EXPECT_DOUBLE_EQ(quantile({}, 0.5), 0.0);
}

TEST(Summarize, AgreesWithNumbersWorkedOutByHand) {
  const Summary summary = summarize({2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0});
  EXPECT_DOUBLE_EQ(summary.mean, 5.0);
  EXPECT_DOUBLE_EQ(summary.sd, std::sqrt(32.0 / 7.0));
  EXPECT_DOUBLE_EQ(summary.median, 4.5);
  EXPECT_DOUBLE_EQ(summary.p95, 7.0 + 0.65 * 2.0);
  EXPECT_DOUBLE_EQ(summary.max, 9.0);
}

TEST(Summarize, TakesOneValueAndNone) {
  const Summary one = summarize({-3.0});
  EXPECT_DOUBLE_EQ(one.mean, -3.0);
  EXPECT_DOUBLE_EQ(one.sd, 0.0);
  EXPECT_DOUBLE_EQ(one.max, -3.0);
  EXPECT_DOUBLE_EQ(summarize({}).mean, 0.0);
}

}  // namespace
}  // namespace mor
