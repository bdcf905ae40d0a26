// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/corrected_calibration.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::HasSubstr;

/// Millimetres here and there, as boards and skins find them.
DepthCorrection correction(int columns, int rows, double scale) {
  DepthCorrection result{.columns = columns, .rows = rows, .control = {}, .curve = {}};
  for (int i = 0; i < columns * rows; ++i) {
    result.control.push_back(
        {scale * std::sin(1.7 * i), 0.004 * scale * std::cos(0.9 * i), 2e-6 * scale});
  }
  return result;
}

TEST(CorrectedCalibration, TwoCorrectionsAreOne) {
  auto first = correction(7, 6, 1.5);
  first.curve = {{500.0, 2.0}, {900.0, -1.0}};
  const auto second = correction(13, 10, -0.8);
  const auto both = corrected_after(first, second);
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->columns, 13);
  EXPECT_EQ(both->rows, 46);
  for (int x = 0; x < 640; x += 37) {
    for (int y = 0; y < 480; y += 29) {
      for (const double z_mm : {450.0, 700.0, 1100.0}) {
        const Eigen::Vector2d pixel(x, y);
        const double once_mm = z_mm + first.add_mm(pixel, 640, 480, z_mm);
        const double twice_mm = once_mm + second.add_mm(pixel, 640, 480, once_mm);
        EXPECT_NEAR(z_mm + both->add_mm(pixel, 640, 480, z_mm), twice_mm, 0.02);
      }
    }
  }
}

TEST(CorrectedCalibration, HoldsWhereBothHold) {
  auto first = correction(2, 2, 1.0);
  first.near_mm = 600.0;
  first.far_mm = 2000.0;
  auto second = correction(3, 3, 1.0);
  second.near_mm = 400.0;
  second.far_mm = 900.0;
  const auto both = corrected_after(first, second).value();
  EXPECT_EQ(both.near_mm, 600.0);
  EXPECT_EQ(both.far_mm, 900.0);
  second.far_mm = 590.0;
  EXPECT_THAT(corrected_after(first, second).error().message, HasSubstr("share no distances"));
  second.curve = {{500.0, 1.0}};
  EXPECT_THAT(corrected_after(first, second).error().message, HasSubstr("curve"));
}

TEST(CorrectedCalibration, TakesTheFoundPinholeAndKeepsTheColorCamera) {
  RgbdCalibration in_use;
  in_use.depth = {640, 480, 525.0, 525.0, 319.5, 239.5, {}};
  in_use.color = in_use.depth;
  SelfCalibration found;
  found.depth = in_use.depth;
  found.depth.focal_x_px = 527.0;
  found.correction = correction(13, 10, 1.0);
  const auto first = without_error(in_use, found).value();
  EXPECT_EQ(first.depth.focal_x_px, 527.0);
  EXPECT_EQ(first.color.focal_x_px, 525.0);
  EXPECT_EQ(*first.depth_correction, found.correction);
  const auto second = without_error(first, found).value();
  EXPECT_NE(*second.depth_correction, found.correction) << "what was there before stays in it";
}

}  // namespace
}  // namespace mor
