// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/judgement.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A frame without any fault; each test spoils one thing.
struct Frame : FrameEvidence {
  Frame() {
    PoseInformation information;
    information.matrix.diagonal() << 1e7, 1e7, 1e7, 1e4, 1e4, 1e4;
    information.residual_scale = 0.8;
    information.num_pairs = 3000;
    result.status = RegistrationStatus::kConverged;
    result.rms_distance_mm = 1.2;
    result.explained_fraction = 0.8;
    result.information = information;
    skin.num_samples = 1500;
    skin.num_expected = 400;
    skin.num_seen = 380;
    skin.num_covered = 20;
    skin.num_patches = 300;
    skin.seen_radius_mm = 80.0;
    surface_relief_mm = 30.0;
    expected = ExpectedPose{Eigen::Isometry3d::Identity(), std::chrono::milliseconds(33)};
  }

  [[nodiscard]] Judgement judged() {
    covariance = pose_covariance(*result.information);
    return judge_evidence(*this);
  }
};

TEST(JudgeEvidence, FindsNoFaultInAGoodFrame) {
  Frame frame;
  const auto judgement = frame.judged();
  EXPECT_EQ(judgement.verdict, Verdict::kGood);
  EXPECT_THAT(judgement.doubts, IsEmpty());
}

TEST(JudgeEvidence, LittleSkinSeenAlone) {
  Frame frame;
  frame.skin.num_seen = 160;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.skin.num_seen = 80;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kLittleSeen));
  frame.skin = {};
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad) << "no skin expected at all";
}

TEST(JudgeEvidence, AGlimpseOfTheBodyAlone) {
  Frame frame;
  frame.skin.num_expected = frame.skin.num_seen = 60;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.skin.num_expected = frame.skin.num_seen = 30;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kLittleSeen));
}

TEST(JudgeEvidence, WhatIsNotThisBodyAlone) {
  Frame frame;
  frame.result.explained_fraction = 0.1;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.result.explained_fraction = 0.02;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kUnexplained));
}

TEST(JudgeEvidence, FloatingSkinAlone) {
  Frame frame;
  frame.skin.num_floating = 25;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.skin.num_floating = 60;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kFloating));
}

TEST(JudgeEvidence, TheResidualAlone) {
  Frame frame;
  frame.result.information->residual_scale = 3.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.result.information->residual_scale = 5.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kResidual));
  frame.result.information->residual_scale = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
}

TEST(JudgeEvidence, AResidualInWavesAlone) {
  Frame frame;
  frame.result.information->unevenness = 2.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kGood);
  frame.result.information->unevenness = 4.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.result.information->unevenness = 12.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kResidual));
}

TEST(JudgeEvidence, SkinBeforeWhatIsSeenByMillimetresAlone) {
  Frame frame;
  frame.skin.num_behind = 15;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  frame.skin.num_behind = 60;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kResidual));
}

TEST(JudgeEvidence, AnOpenDirectionAlone) {
  Frame frame;
  frame.result.information->matrix(3, 3) = 1e-6;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kOpenDirection));
  frame = {};
  frame.result.information->matrix(0, 0) = 20.0;
  frame.skin.seen_center_mm = {0.0, 200.0, 0.0};
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak) << "far from the pivot";
  frame = {};
  frame.surface_relief_mm = 2.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak) << "a flat surface fits anything flat";
}

/// A head seen from above: about the axis that it is seen along it may turn.
TEST(JudgeEvidence, ATurnAboutAnAxisThroughTheMiddleOfTheSkinSeenAlone) {
  for (int axis = 0; axis < 3; ++axis) {
    Frame frame;
    frame.result.information->matrix(axis, axis) = 20.0;
    EXPECT_EQ(frame.judged().verdict, Verdict::kWeak) << "13 degrees open";
    EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kOpenDirection));
    frame.skin.seen_radius_mm = 5.0;
    EXPECT_EQ(frame.judged().verdict, Verdict::kGood) << "it moves none of the skin seen by 5 mm";
  }
}

TEST(JudgeEvidence, AJumpAlone) {
  Frame frame;
  frame.expected->ct_from_depth.translation().x() = 60.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kGood) << "a fast hand";
  frame.expected->ct_from_depth.translation().x() = 90.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kWeak);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kJump));
  frame.expected->ct_from_depth =
      Eigen::Isometry3d(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kJump));
}

TEST(JudgeEvidence, NoPoseAlone) {
  Frame frame;
  frame.result.status = RegistrationStatus::kTooFewPairs;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kNoBody));
}

TEST(JudgeEvidence, TheWorstDoubtDecidesAndAllAreNamed) {
  Frame frame;
  frame.skin.num_seen = 160;
  frame.result.information->residual_scale = 5.0;
  EXPECT_EQ(frame.judged().verdict, Verdict::kBad);
  EXPECT_THAT(frame.judged().doubts, ElementsAre(Doubt::kLittleSeen, Doubt::kResidual));
}

TEST(ReliefMm, IsTheSpreadAcrossTheSurfacesOwnPlane) {
  PointCloud cloud;
  for (int i = 0; i < 4000; ++i) {
    const auto u = static_cast<float>(i % 63);
    const auto v = static_cast<float>(i / 63);
    cloud.points.emplace_back(u, v + u, 600.0F + v - u + (i % 16 < 8 ? 3.0F : -3.0F));
  }
  EXPECT_NEAR(relief_mm(cloud), 3.0 / std::sqrt(1.0 + 4.0 + 1.0), 0.1);
  EXPECT_EQ(relief_mm({}), 0.0);
}

TEST(JudgementLimits, NameThePairThatIsTheWrongWayRound) {
  JudgementLimits limits;
  limits.floating_fraction = {0.5, 0.1};
  EXPECT_THAT(limits.check().error().message, HasSubstr("floating_fraction"));
}

}  // namespace
}  // namespace mor
