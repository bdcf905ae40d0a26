// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/texture_evaluation.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/evaluation/internal/atlas_picture.h"
#include "morgagni/evaluation/internal/color_difference.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using ::testing::HasSubstr;

TEST(ColorDifference, IsThatOfThePublishedPairs) {
  // Sharma, Wu, Dalal 2005, table 1.
  const struct {
    Eigen::Vector3d a;
    Eigen::Vector3d b;
    double difference;
  } pairs[] = {
      {{50.0, 2.6772, -79.7751}, {50.0, 0.0, -82.7485}, 2.0425},
      {{50.0, 2.8361, -74.0200}, {50.0, 0.0, -82.7485}, 3.4412},
      {{50.0, -1.3802, -84.2814}, {50.0, 0.0, -82.7485}, 1.0000},
      {{50.0, 2.5, 0.0}, {50.0, 0.0, -2.5}, 4.3065},
      {{50.0, 2.5, 0.0}, {73.0, 25.0, -18.0}, 27.1492},
      {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
      {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
      {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
  };
  for (const auto& [a, b, difference] : pairs) {
    EXPECT_NEAR(internal::ciede2000(a, b), difference, 1e-4);
    EXPECT_NEAR(internal::ciede2000(b, a), difference, 1e-4);
  }
}

TEST(ColorDifference, WhiteHasNoColour) {
  EXPECT_LT((internal::lab_from_srgb({255, 255, 255}) - Eigen::Vector3d(100, 0, 0)).norm(), 0.02);
  EXPECT_NEAR(internal::lab_from_srgb({119, 119, 119}).x(), 50.0, 0.2);
}

/// Blots, moved by `shift_px`.
internal::AtlasPicture blots(float shift_px, float gain) {
  internal::AtlasPicture picture{Image<Eigen::Vector3f>(96, 96), Image<float>(96, 96, 1.0F)};
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      const float at = static_cast<float>(x) - shift_px;
      const float wave = std::sin(0.5F * at) * std::cos(0.4F * static_cast<float>(y)) +
                         std::sin(0.23F * at + 0.31F * static_cast<float>(y));
      picture.color(x, y) = gain * Eigen::Vector3f(150, 120 + 20 * wave, 100 + 10 * wave);
    }
  }
  return picture;
}

TEST(AtlasPicture, MeasuresAKnownShiftAndIsBlindToExposure) {
  const auto truth = blots(0.0F, 1.0F);
  const auto same = internal::compare_pictures(blots(0.0F, 0.7F), truth);
  EXPECT_LT(summarize(same.color_difference).max, 0.01);
  EXPECT_LT(summarize(same.misplacement_px).max, 0.02);
  const auto shifted = internal::compare_pictures(blots(1.5F, 1.0F), truth);
  ASSERT_GT(shifted.misplacement_px.size(), 20U);
  EXPECT_NEAR(summarize(shifted.misplacement_px).median, 1.5, 0.05);
}

TEST(AtlasPicture, MeasuresGradientEnergy) {
  const auto sharp = blots(0.0F, 1.0F);
  auto soft = sharp;
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      soft.color(x, y).y() = 120.0F + 0.5F * (sharp.color(x, y).y() - 120.0F);
      soft.color(x, y).z() = 100.0F + 0.5F * (sharp.color(x, y).z() - 100.0F);
    }
  }
  const auto energy = internal::gradient_energy(soft, sharp, 0.5F);
  EXPECT_NEAR(energy.of_a / energy.of_b, 0.25, 0.02);
  EXPECT_EQ(internal::gradient_energy(soft, sharp, 2.0F).num_steps, 0U);
}

TEST(TextureStudy, MeltingKeepsPlaceColourAndDetail) {
  TextureStudyOptions options;
  options.camera = "path=pass,skin=marked,exposure=0.3,clutter=hand,fps=5,distance=550";
  options.num_frames = 150;
  options.fuse_every = 2;
  options.truth_every = 10;
  options.single_every = 30;
  options.clutter_period = 40;
  const auto study = run_texture_study(internal::bumpy_surface(), options, [](auto, auto) {});
  ASSERT_TRUE(study.has_value()) << study.error().message;
  EXPECT_LE(study->fused.color_difference.median, 3.0);
  EXPECT_LT(study->fused.color_difference.p95, study->single.color_difference.p95);
  EXPECT_LE(study->fused.misplacement_px.p95, 1.0);
  EXPECT_GE(study->least_gradient_ratio, 0.9);
  EXPECT_GT(study->fused.num_patches, 50U);
  EXPECT_GT(study->coverage_of_visible, 0.6);
  EXPECT_THAT(to_markdown(*study), HasSubstr("| fused |"));
}

TEST(TextureStudy, NamesABadOption) {
  TextureStudyOptions options;
  options.fuse_every = 0;
  const auto study = run_texture_study(internal::bumpy_surface(20), options, [](auto, auto) {});
  ASSERT_FALSE(study.has_value());
  EXPECT_THAT(study.error().message, HasSubstr("fuse_every must be at least 1, got 0"));
}

}  // namespace
}  // namespace mor
