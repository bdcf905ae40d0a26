// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/tracker.h"

#include <cmath>
#include <deque>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using std::chrono::milliseconds;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr PinholeCamera kCamera{320, 240, 260.0, 260.0, 159.5, 119.5, {}};
constexpr float kWallMm = 600.0F;

/// Answers with the results it was told, and keeps the poses it was started from. The state machine
/// is under test here, not the registration.
class ScriptedRegistration final : public FineRegistration {
 public:
  struct Script {
    std::deque<RegistrationResult> results;
    std::vector<double> init_x_mm;
    std::vector<StartQuality> starts;
  };

  explicit ScriptedRegistration(std::shared_ptr<Script> script) : script_(std::move(script)) {}

  Result<RegistrationResult> align(const PointCloud& /*moving*/,
                                   const Eigen::Isometry3d& init,
                                   StartQuality start) const override {
    script_->init_x_mm.push_back(init.translation().x());
    script_->starts.push_back(start);
    const auto result = script_->results.front();
    if (script_->results.size() > 1) script_->results.pop_front();
    return result;
  }

 private:
  std::shared_ptr<Script> script_;
};

/// What is flat fits anything flat: the wall has waves from top to bottom.
double relief_at(double row_px) {
  return 7.8 * std::sin(0.1 * row_px);
}

/// A skin that is the wall which the frames show.
FixedSurface wall() {
  FixedSurface fixed;
  for (int y = -20; y <= 20; ++y) {
    for (int x = -20; x <= 20; ++x) {
      const double row_px = 119.5 + 260.0 * 20.0 * y / kWallMm;
      fixed.mesh.vertices.emplace_back(
          20.0F * x, 20.0F * y, static_cast<float>(kWallMm + relief_at(row_px)));
      fixed.mesh.normals.emplace_back(0.0F, 0.0F, -1.0F);
    }
  }
  fixed.mesh.triangles.push_back({0, 1, 41});
  return fixed;
}

Eigen::Isometry3d at(double x_mm, double z_mm = 0.0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << x_mm, 0.0, z_mm;
  return pose;
}

/// What a method without information says: ICP.
RegistrationResult residual(double x_mm, double rms_mm, double explained = 0.9) {
  RegistrationResult result;
  result.fixed_from_moving = at(x_mm);
  result.status = RegistrationStatus::kConverged;
  result.rms_distance_mm = rms_mm;
  result.explained_fraction = explained;
  result.num_pairs = 1000;
  return result;
}

RegistrationResult good(double x_mm, double z_mm = 0.0, double residual_scale = 0.8) {
  auto result = residual(x_mm, 1.2);
  result.fixed_from_moving = at(x_mm, z_mm);
  PoseInformation information;
  information.matrix.diagonal() << 1e8, 1e8, 1e8, 1e5, 1e5, 1e5;
  information.residual_scale = residual_scale;
  information.num_pairs = 1000;
  result.information = information;
  return result;
}

RegistrationResult weak(double x_mm) {
  return good(x_mm, 0.0, 3.0);
}

/// The skin would float 50 mm before the wall.
RegistrationResult wrong() {
  return good(0.0, 50.0);
}

class TrackerTest : public testing::Test {
 protected:
  Tracker make(std::deque<RegistrationResult> results,
               TrackingGate gate = TrackingGate::kEvidence) {
    script_->results = std::move(results);
    TrackingOptions options;
    options.gate = gate;
    return Tracker::create(options,
                           std::make_shared<const FixedSurface>(wall()),
                           BodySurfaceExtractor::create(kCamera, {}).value(),
                           std::make_unique<ScriptedRegistration>(script_))
        .value();
  }
  /// One that tracks since 0 ms, from x = 0.
  Tracker started(std::deque<RegistrationResult> results,
                  TrackingGate gate = TrackingGate::kEvidence) {
    results.push_front(gate == TrackingGate::kEvidence ? good(0.0) : residual(0.0, 2.0));
    auto tracker = make(std::move(results), gate);
    EXPECT_TRUE(tracker.start_at(frame(milliseconds(0)), at(0.0)));
    script_->init_x_mm.clear();
    script_->starts.clear();
    return tracker;
  }

  /// A wall, `when` after the first frame.
  static std::shared_ptr<const RgbdFrame> frame(milliseconds when, std::uint16_t depth_mm = 600) {
    static const auto kCalibration =
        std::make_shared<const RgbdCalibration>(RgbdCalibration{kCamera, kCamera, {}});
    auto frame = std::make_shared<RgbdFrame>();
    frame->captured_at = std::chrono::steady_clock::time_point(std::chrono::hours(1)) + when;
    frame->depth_mm = Image<std::uint16_t>(320, 240);
    for (int y = 0; y < 240 && depth_mm > 0; ++y) {
      for (int x = 0; x < 320; ++x) {
        frame->depth_mm(x, y) = static_cast<std::uint16_t>(std::lround(depth_mm + relief_at(y)));
      }
    }
    frame->calibration = kCalibration;
    return frame;
  }

  std::shared_ptr<ScriptedRegistration::Script> script_ =
      std::make_shared<ScriptedRegistration::Script>();
};

TEST_F(TrackerTest, WaitsWithoutAStartAndAsksForOne) {
  auto tracker = make({good(0.0)});
  const auto tracked = tracker.process(frame(milliseconds(0))).value();
  EXPECT_EQ(tracked.state, TrackingState::kWaiting);
  EXPECT_FALSE(tracked.ct_from_depth);
  EXPECT_FALSE(tracked.registration);
  EXPECT_TRUE(tracked.needs_start);
  EXPECT_FALSE(tracker.process(frame(milliseconds(33), 0))->needs_start) << "there is no body";
}

TEST_F(TrackerTest, APlacementCatchesOnlyWhenTheBodyFits) {
  auto tracker = make({wrong(), weak(2.0), good(3.0)});
  tracker.start_by_placement(at(7.0));
  auto tracked = tracker.process(frame(milliseconds(0))).value();
  EXPECT_EQ(tracked.state, TrackingState::kWaiting);
  EXPECT_FALSE(tracked.ct_from_depth) << "a start that does not fit is never shown";
  EXPECT_TRUE(tracked.ct_from_ghost);
  EXPECT_FALSE(tracked.needs_start);
  EXPECT_EQ(tracker.process(frame(milliseconds(33)))->state, TrackingState::kWaiting);
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 3.0);
  EXPECT_FALSE(tracked.ct_from_ghost);
  EXPECT_THAT(script_->init_x_mm, ElementsAre(7.0, 7.0, 7.0));
}

TEST_F(TrackerTest, EachFrameStartsWhereTheMotionPutsIt) {
  auto tracker = started({good(3.0), good(6.0)});
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(tracker.process(frame(milliseconds(30 * i))));
  ASSERT_EQ(script_->init_x_mm.size(), 3U);
  EXPECT_NEAR(script_->init_x_mm[0], 0.0, 1e-9);
  EXPECT_NEAR(script_->init_x_mm[1], 6.0, 1e-9);
  EXPECT_NEAR(script_->init_x_mm[2], 9.0, 1e-9);
  EXPECT_THAT(script_->starts, Each(StartQuality::kTracked));
}

TEST_F(TrackerTest, AWeakFrameIsShownAsUncertainWithItsReason) {
  auto tracker = started({weak(3.0), good(4.0)});
  auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kUncertain);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 3.0) << "the frame's own pose";
  EXPECT_FALSE(tracked.is_held);
  EXPECT_TRUE(tracked.covariance);
  EXPECT_THAT(tracked.doubts, ElementsAre(Doubt::kResidual));
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_THAT(tracked.doubts, IsEmpty());
  EXPECT_EQ(tracked.counts.tracked, 1U);
  EXPECT_EQ(tracked.counts.uncertain, 1U);
}

TEST_F(TrackerTest, ABadFrameHoldsThePoseAndLooksAround) {
  auto tracker = started({good(3.0), wrong()});
  ASSERT_TRUE(tracker.process(frame(milliseconds(33))));
  const auto tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kUncertain);
  EXPECT_TRUE(tracked.is_held);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 3.0);
  EXPECT_FALSE(tracked.covariance) << "nobody knows how far a held pose is off";
  EXPECT_THAT(tracked.doubts, Contains(Doubt::kFloating));
  EXPECT_GT(std::count(script_->starts.begin(), script_->starts.end(), StartQuality::kRough), 3);
}

TEST_F(TrackerTest, IsLostAfterTheTimeShowsNoPoseAndAsksForAStart) {
  auto tracker = started({wrong()});
  EXPECT_FALSE(tracker.process(frame(milliseconds(33)))->needs_start);
  EXPECT_EQ(tracker.process(frame(milliseconds(499)))->state, TrackingState::kUncertain);
  const auto tracked = tracker.process(frame(milliseconds(500))).value();
  EXPECT_EQ(tracked.state, TrackingState::kLost);
  EXPECT_FALSE(tracked.ct_from_depth);
  EXPECT_TRUE(tracked.needs_start);
  EXPECT_EQ(tracker.process(frame(milliseconds(3000)))->counts.lost, 1U)
      << "lost once, not each frame";
}

TEST_F(TrackerTest, ResumesByItselfOnlyOnAGoodFrame) {
  auto tracker = started({wrong()});
  EXPECT_EQ(tracker.process(frame(milliseconds(5000)))->state, TrackingState::kLost);
  script_->results = {weak(3.0)};
  EXPECT_EQ(tracker.process(frame(milliseconds(6000)))->state, TrackingState::kLost);
  script_->results = {good(4.0)};
  const auto tracked = tracker.process(frame(milliseconds(7000))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 4.0);
  EXPECT_EQ(tracked.counts.resumed, 1U);
}

TEST_F(TrackerTest, AJumpIsBelievedWhenTheNextFrameSaysTheSame) {
  auto tracker = started({good(100.0)});
  auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kUncertain);
  EXPECT_THAT(tracked.doubts, ElementsAre(Doubt::kJump));
  script_->results = {good(200.0)};
  EXPECT_EQ(tracker.process(frame(milliseconds(66)))->state, TrackingState::kTracking);
}

TEST_F(TrackerTest, ACoveredCameraHoldsThePose) {
  auto tracker = started({good(1.0)});
  const auto tracked = tracker.process(frame(milliseconds(33), 0)).value();
  EXPECT_EQ(tracked.state, TrackingState::kUncertain);
  EXPECT_TRUE(tracked.is_held);
  EXPECT_THAT(tracked.doubts, ElementsAre(Doubt::kNoBody));
  EXPECT_FALSE(tracker.process(frame(milliseconds(66), 0))->needs_start) << "there is no body";
}

TEST_F(TrackerTest, AnOfferedStartIsUsedOnlyWhereItFits) {
  auto tracker = make({wrong()});
  tracker.offer_start(*frame(milliseconds(0)), at(5.0));
  auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kWaiting);
  EXPECT_FALSE(tracked.ct_from_depth);
  EXPECT_FALSE(tracked.needs_start) << "the offer is still being tried";
  script_->results = {good(6.0)};
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_NEAR(script_->init_x_mm.front(), 5.0, 1e-9);
}

TEST_F(TrackerTest, AnOfferThatNeverFitsIsForgotten) {
  auto tracker = make({wrong()});
  tracker.offer_start(*frame(milliseconds(0)), at(5.0));
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(tracker.process(frame(milliseconds(33 * i))));
  EXPECT_TRUE(tracker.process(frame(milliseconds(400)))->needs_start);
}

TEST_F(TrackerTest, RefusesAStartThatDoesNotFitAndSaysByHowMuch) {
  auto tracker = make({wrong()});
  const auto refused = tracker.start_at(frame(milliseconds(0)), at(0.0));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("100 % of it would float"));
  EXPECT_THAT(refused.error().message, HasSubstr("residual 1.2 mm (limit 6.0 mm)"));
  EXPECT_EQ(tracker.process(frame(milliseconds(33)))->state, TrackingState::kWaiting);
}

TEST_F(TrackerTest, WaitsAgainWhenTold) {
  auto tracker = started({good(1.0)});
  tracker.wait_for_start();
  const auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kWaiting);
  EXPECT_FALSE(tracked.ct_from_depth);
}

TEST_F(TrackerTest, AMethodWithoutInformationIsJudgedByItsResidualAndHasNoBound) {
  auto tracker = make({residual(0.0, 1.0), residual(1.0, 1.2), residual(2.0, 9.0)});
  ASSERT_TRUE(tracker.start_at(frame(milliseconds(0)), at(0.0)));
  auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_FALSE(tracked.covariance);
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kUncertain);
  EXPECT_THAT(tracked.doubts, ElementsAre(Doubt::kResidual));
}

// The paper's gate.

TEST_F(TrackerTest, ResidualGateHoldsThePoseAtAlphaTimesTheResidualOfTheStart) {
  auto tracker = started({residual(2.0, 2.99), residual(3.0, 3.0)}, TrackingGate::kResidual);
  auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(*tracked.valid_rms_mm, 2.0);
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kUncertain);
  EXPECT_TRUE(tracked.is_held);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 2.0) << "the pose is kept";
  EXPECT_EQ(tracked.counts.uncertain, 1U);
  EXPECT_EQ(tracked.counts.tracked, 1U);
}

TEST_F(TrackerTest, ResidualGateStartsEachFrameFromTheLastValidPose) {
  auto tracker = started({residual(1.0, 2.0), residual(2.0, 2.0), residual(90.0, 5.0)},
                         TrackingGate::kResidual);
  for (int i = 1; i <= 4; ++i) ASSERT_TRUE(tracker.process(frame(milliseconds(33 * i))));
  EXPECT_THAT(script_->init_x_mm, ElementsAre(0.0, 1.0, 2.0, 2.0));
  EXPECT_THAT(script_->starts,
              ElementsAre(StartQuality::kTracked,
                          StartQuality::kTracked,
                          StartQuality::kTracked,
                          StartQuality::kRough));
}

TEST_F(TrackerTest, ResidualGateResumesWhenTheConstraintHoldsAgain) {
  auto tracker = started({residual(2.0, 50.0), residual(3.0, 2.4)}, TrackingGate::kResidual);
  EXPECT_EQ(tracker.process(frame(milliseconds(5000)))->state, TrackingState::kLost);
  const auto tracked = tracker.process(frame(milliseconds(6000))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 3.0);
}

TEST_F(TrackerTest, ResidualGateRefusesAStartThatExplainsTooLittle) {
  auto tracker = make({residual(1.0, 1.0, 0.31)}, TrackingGate::kResidual);
  const auto refused = tracker.start_at(frame(milliseconds(0)), at(0.0));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("31 %"));
}

TEST(TrackingOptions, NameTheValueAndTheLimit) {
  TrackingOptions options;
  options.residual_ratio = 1.0;
  EXPECT_THAT(options.check().error().message, HasSubstr("residual_ratio must be above 1, got 1"));
  options = {};
  options.sensor_bias_mm = -1.0;
  EXPECT_FALSE(options.check());
  options = {};
  options.lost_after = milliseconds(0);
  EXPECT_FALSE(options.check());
  options = {};
  options.start_min_explained = 1.5;
  EXPECT_FALSE(options.check());
}

}  // namespace
}  // namespace mor
