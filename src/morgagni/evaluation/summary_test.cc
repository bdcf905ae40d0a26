// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "morgagni/evaluation/summary.h"

namespace mor {
namespace {

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
