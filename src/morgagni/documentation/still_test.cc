// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/still.h"

#include <cmath>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

constexpr PinholeCamera kCamera{640, 480, 525.0, 525.0, 319.5, 239.5, {}};

Image<Rgba8> picture() {
  Image<Rgba8> image(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x)
      image(x, y) = {static_cast<std::uint8_t>(x / 3), static_cast<std::uint8_t>(y / 2), 90, 255};
  }
  return image;
}

/// From the front of a body that lies on its back with the head to the left.
Eigen::Isometry3d head_left() {
  Eigen::Isometry3d camera_from_ct = Eigen::Isometry3d::Identity();
  // Right of the picture is the body's feet, its lower edge the body's right.
  camera_from_ct.linear() << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  camera_from_ct.translation() = Eigen::Vector3d(0, 0, 700);
  return camera_from_ct;
}

StillWords words() {
  return {.case_name = "case 0815",
          .taken_at = "2026-11-26T16:20:05Z",
          .state = "tracking",
          .bound_mm = 2.1,
          .made_by = "Morgagni 0.1.0, frame 7",
          .camera = kCamera,
          .camera_from_ct = head_left(),
          .scale_depth_mm = 700.0,
          .scale_place = "on the skin in the middle of the hole",
          .marks = {}};
}

TEST(Still, ThePlainOneIsThePictureAndNothingElse) {
  const auto image = picture();
  const auto still = draw_still(image.view(), words(), StillStyle::kPlain);
  ASSERT_TRUE(still);
  ASSERT_EQ(still->width(), 640);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x)
      ASSERT_EQ((*still)(x, y), (Rgb8{image(x, y).r, image(x, y).g, image(x, y).b}));
  }
}

TEST(Still, BesideLeavesThePictureAsItIsPixelByPixel) {
  const auto image = picture();
  const auto still = draw_still(image.view(), words(), StillStyle::kBeside);
  ASSERT_TRUE(still);
  ASSERT_EQ(still->width(), 1280) << "twice as large";
  ASSERT_GT(still->height(), 960 + 100) << "and a panel below";
  for (int y = 0; y < 960; ++y) {
    for (int x = 0; x < 1280; ++x) {
      const Rgba8& p = image(x / 2, y / 2);
      ASSERT_EQ((*still)(x, y), (Rgb8{p.r, p.g, p.b})) << x << ", " << y;
    }
  }
}

/// Length of the longest run of dark pixels in a row of the panel's left third, which is the bar.
int longest_dark_run(const Image<Rgb8>& still, int from_y) {
  int longest = 0;
  for (int y = from_y; y < still.height(); ++y) {
    int run = 0;
    for (int x = 0; x < still.width() / 3; ++x) {
      const Rgb8 p = still(x, y);
      run = p.r < 60 && p.g < 60 && p.b < 60 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  return longest;
}

TEST(Still, TheScaleBarIsAsLongAsItSays) {
  const auto bar = scale_bar(kCamera, 700.0);
  EXPECT_EQ(bar.length_mm, 200.0);
  EXPECT_DOUBLE_EQ(bar.length_px, 200.0 * 525.0 / 700.0);
  EXPECT_EQ(scale_bar(kCamera, 300.0).length_mm, 50.0);
  EXPECT_EQ(scale_bar(kCamera, 60.0).length_mm, 10.0);
  const auto still = draw_still(picture().view(), words(), StillStyle::kBeside).value();
  // Twice as large, and the line's round ends: 0.2 of the words' height, 24 px.
  EXPECT_NEAR(longest_dark_run(still, 960), 2.0 * bar.length_px + 0.2 * 0.019 * 1280.0, 2.5);
}

TEST(Still, WithoutAPoseThereIsNoBarAndNoCompass) {
  auto lost = words();
  lost.camera_from_ct.reset();
  lost.scale_depth_mm.reset();
  lost.bound_mm.reset();
  const auto still = draw_still(picture().view(), lost, StillStyle::kBeside);
  ASSERT_TRUE(still);
  EXPECT_LT(longest_dark_run(*still, 960), 30) << "words reach so far to the left, no bar";
}

TEST(Still, TheCompassPointsWhereTheBodyLies) {
  std::map<char, CompassLetter> by_letter;
  for (const auto& letter : compass(head_left())) by_letter[letter.letter] = letter;
  ASSERT_EQ(by_letter.size(), 6U);
  EXPECT_LT((by_letter['H'].direction - Eigen::Vector2d(-1, 0)).norm(), 1e-12) << "head left";
  EXPECT_LT((by_letter['F'].direction - Eigen::Vector2d(1, 0)).norm(), 1e-12);
  EXPECT_LT((by_letter['R'].direction - Eigen::Vector2d(0, 1)).norm(), 1e-12) << "right below";
  EXPECT_NEAR(by_letter['A'].towards_viewer, 1.0, 1e-12) << "the front faces the camera";
  EXPECT_NEAR(by_letter['P'].towards_viewer, -1.0, 1e-12);
}

TEST(Still, MarksLieOnTheirPixels) {
  auto marked = words();
  marked.marks = {{.id = "F1", .label = "", .points_px = {{400, 300}}, .line_px = {}}};
  const auto still = draw_still(picture().view(), marked, StillStyle::kBurnedIn).value();
  // A yellow ring around the pixel, whose middle lies at twice (400.5, 300.5).
  const double radius = 0.42 * 0.019 * 1280.0;
  for (const auto& [dx, dy] : {std::pair(1.0, 0.0), {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}}) {
    const Rgb8 p =
        still(static_cast<int>(801.0 + radius * dx), static_cast<int>(601.0 + radius * dy));
    EXPECT_GT(p.r, 200);
    EXPECT_LT(p.b, 110);
  }
  EXPECT_EQ(still(801, 601), (Rgb8{400 / 3, 300 / 2, 90})) << "what is marked is not covered";
}

TEST(Still, TakesOddSizesAndLongNames) {
  for (const auto& [width, height] : {std::pair(641, 479), {1920, 1080}, {17, 16}}) {
    auto odd = words();
    odd.case_name = std::string(300, 'x') + " \xF0\x9F\xAB\x80 <b>no markup</b>";
    odd.camera = {width, height, 500.0, 500.0, width / 2.0, height / 2.0, {}};
    const Image<Rgba8> image(width, height, {10, 20, 30, 255});
    for (const auto style : {StillStyle::kPlain, StillStyle::kBurnedIn, StillStyle::kBeside})
      EXPECT_TRUE(draw_still(image.view(), odd, style)) << width;
  }
  const Image<Rgba8> small(20, 20);
  EXPECT_FALSE(draw_still(small.view(), words(), StillStyle::kBeside));
}

TEST(Still, StylesHaveNames) {
  for (const auto style : {StillStyle::kPlain, StillStyle::kBurnedIn, StillStyle::kBeside})
    EXPECT_EQ(parse_still_style(to_string(style)), style);
  EXPECT_FALSE(parse_still_style("fancy"));
}

}  // namespace
}  // namespace mor
