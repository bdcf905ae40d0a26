// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/skin_evidence.h"

#include <cmath>

#include <gtest/gtest.h>

#include "morgagni/geometry/depth_raster.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

constexpr PinholeCamera kCamera{320, 240, 262.0, 262.0, 159.5, 119.5, {}};
constexpr double kToleranceMm = 8.0;

/// A body before a wall, as a camera without noise sees it.
class SkinEvidenceTest : public testing::Test {
 protected:
  SkinEvidenceTest()
      : body_(internal::bumpy_body(100, {30.0F, -200.0F, 400.0F})),
        samples_(body_),
        truth_(internal::camera_before_body()),
        depth_mm_(320, 240, 1200) {
    const auto seen = rasterize_depth(body_, kCamera, truth_.inverse());
    for (std::size_t i = 0; i < depth_mm_.size(); ++i) {
      const float z_mm = seen.depth_mm.data()[i];
      if (z_mm > 0.0F) depth_mm_.data()[i] = static_cast<std::uint16_t>(std::lround(z_mm));
    }
  }

  [[nodiscard]] SkinEvidence at(const Eigen::Isometry3d& ct_from_depth) const {
    return samples_.compare(depth_mm_.view(), kCamera, ct_from_depth, kToleranceMm);
  }
  /// The truth with the camera moved along its own axes.
  [[nodiscard]] Eigen::Isometry3d moved(double x_mm, double z_mm) const {
    return truth_ * Eigen::Translation3d(x_mm, 0.0, z_mm);
  }

  TriangleMesh body_;
  SkinSamples samples_;
  Eigen::Isometry3d truth_;
  Image<std::uint16_t> depth_mm_;
};

TEST_F(SkinEvidenceTest, AllIsSeenWhereThePoseIsRight) {
  const auto evidence = at(truth_);
  EXPECT_GT(evidence.num_expected, 300);
  EXPECT_GT(evidence.seen_fraction(), 0.98);
  EXPECT_LT(evidence.floating_fraction(), 0.005);
  EXPECT_LT(evidence.behind_fraction(), 0.01);
  EXPECT_NEAR(evidence.seen_share(), 0.25, 0.15);
  EXPECT_LT((evidence.seen_center_mm - Eigen::Vector3d(30.0, -270.0, 400.0)).norm(), 60.0);
  EXPECT_NEAR(evidence.seen_radius_mm, 110.0, 35.0) << "half of 240 x 300 mm, less at the outline";
}

TEST_F(SkinEvidenceTest, SkinFloatsWhereTheCameraIsTakenToBeNearer) {
  const auto evidence = at(moved(0.0, 30.0));
  EXPECT_GT(evidence.floating_fraction(), 0.9);
  EXPECT_EQ(evidence.num_covered, 0);
}

TEST_F(SkinEvidenceTest, SkinIsCoveredWhereTheCameraIsTakenToBeFarther) {
  const auto evidence = at(moved(0.0, -30.0));
  EXPECT_LT(evidence.seen_fraction(), 0.1);
  EXPECT_GT(evidence.num_covered, 9 * evidence.num_floating);
}

TEST_F(SkinEvidenceTest, APoseASideIsPartlyInTheAir) {
  EXPECT_GT(at(moved(60.0, 0.0)).floating_fraction(), 0.1);
}

TEST_F(SkinEvidenceTest, MillimetresShowInPatches) {
  EXPECT_LT(at(moved(0.0, 0.5)).behind_fraction(), 0.05);
  EXPECT_GT(at(moved(0.0, 4.0)).behind_fraction(), 0.8);
  EXPECT_LT(at(moved(0.0, -4.0)).behind_fraction(), 0.01) << "what lies before it may be clutter";
}

TEST_F(SkinEvidenceTest, ATowelCoversAndDoesNotFloat) {
  for (int y = 60; y < 150; ++y) {
    for (int x = 80; x < 240; ++x) depth_mm_(x, y) = 450;
  }
  const auto evidence = at(truth_);
  EXPECT_GT(evidence.num_covered, 50);
  EXPECT_LT(evidence.floating_fraction(), 0.01);
}

TEST_F(SkinEvidenceTest, WithoutReadingsNothingIsExpected) {
  depth_mm_ = Image<std::uint16_t>(320, 240, 0);
  const auto evidence = at(truth_);
  EXPECT_EQ(evidence.num_expected, 0);
  EXPECT_EQ(evidence.seen_fraction(), 0.0);
  EXPECT_EQ(evidence.floating_fraction(), 0.0);
}

TEST_F(SkinEvidenceTest, ACameraInsideOrTurnedAwaySeesNoSkin) {
  Eigen::Isometry3d away = truth_;
  away.rotate(Eigen::AngleAxisd(3.1, Eigen::Vector3d::UnitX()));
  EXPECT_EQ(at(away).num_expected, 0);
  EXPECT_EQ(at(moved(std::nan(""), 0.0)).num_expected, 0);
}

}  // namespace
}  // namespace mor
