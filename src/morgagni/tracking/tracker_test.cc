// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/tracking/tracker.h"

#include <deque>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr PinholeCamera kCamera{320, 240, 260.0, 260.0, 159.5, 119.5, {}};

/// Answers with the residuals it was told, and keeps the poses it was started from. The state
/// machine is under test here, not the registration.
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

Eigen::Isometry3d at_x(double x_mm) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().x() = x_mm;
  return pose;
}

RegistrationResult result(double x_mm, double rms_mm, double explained = 0.9) {
  return {.fixed_from_moving = at_x(x_mm),
          .status = RegistrationStatus::kConverged,
          .rms_distance_mm = rms_mm,
          .explained_fraction = explained,
          .num_pairs = 1000};
}

class TrackerTest : public testing::Test {
 protected:
  Tracker make(std::deque<RegistrationResult> results) {
    script_->results = std::move(results);
    return Tracker::create({},
                           BodySurfaceExtractor::create(kCamera, {}).value(),
                           std::make_unique<ScriptedRegistration>(script_))
        .value();
  }

  /// A wall at 600 mm, `at` after the first frame.
  std::shared_ptr<const RgbdFrame> frame(milliseconds at, std::uint16_t depth_mm = 600) {
    auto frame = std::make_shared<RgbdFrame>();
    frame->captured_at = std::chrono::steady_clock::time_point(std::chrono::hours(1)) + at;
    frame->depth_mm = Image<std::uint16_t>(320, 240, depth_mm);
    return frame;
  }

  std::shared_ptr<ScriptedRegistration::Script> script_ =
      std::make_shared<ScriptedRegistration::Script>();
};

TEST_F(TrackerTest, WaitsWithoutAStart) {
  auto tracker = make({result(0.0, 1.0)});
  const auto tracked = tracker.process(frame(milliseconds(0))).value();
  EXPECT_EQ(tracked.state, TrackingState::kWaiting);
  EXPECT_FALSE(tracked.ct_from_depth);
  EXPECT_FALSE(tracked.registration);
}

TEST_F(TrackerTest, APlacementCatchesOnlyWhenTheBodyFits) {
  auto tracker = make({result(1.0, 9.0), result(2.0, 1.0, 0.2), result(3.0, 1.0)});
  tracker.start_by_placement(at_x(7.0));
  auto tracked = tracker.process(frame(milliseconds(0))).value();
  EXPECT_EQ(tracked.state, TrackingState::kWaiting);
  EXPECT_FALSE(tracked.ct_from_depth) << "a start that does not fit is never shown";
  EXPECT_TRUE(tracked.ct_from_ghost);
  EXPECT_EQ(tracker.process(frame(milliseconds(33)))->state, TrackingState::kWaiting);
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 3.0);
  EXPECT_FALSE(tracked.ct_from_ghost);
  EXPECT_THAT(script_->init_x_mm, ElementsAre(7.0, 7.0, 7.0));
}

TEST_F(TrackerTest, EachFrameStartsFromTheLastValidPose) {
  auto tracker = make({result(1.0, 1.0), result(2.0, 1.0), result(90.0, 5.0), result(3.0, 1.0)});
  ASSERT_TRUE(tracker.start_at(*frame(milliseconds(0)), at_x(0.5)));
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(tracker.process(frame(milliseconds(33 * i))));
  EXPECT_THAT(script_->init_x_mm, ElementsAre(0.5, 1.0, 2.0, 2.0));
  EXPECT_THAT(script_->starts,
              ElementsAre(StartQuality::kRough,
                          StartQuality::kTracked,
                          StartQuality::kTracked,
                          StartQuality::kRough));
}

TEST_F(TrackerTest, SkipsAFrameAtAlphaTimesTheResidualOfTheStart) {
  auto tracker = make({result(1.0, 2.0), result(2.0, 2.99), result(3.0, 3.0)});
  ASSERT_TRUE(tracker.start_at(*frame(milliseconds(0)), at_x(0.0)));
  auto tracked = tracker.process(frame(milliseconds(33))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(*tracked.valid_rms_mm, 2.0);
  tracked = tracker.process(frame(milliseconds(66))).value();
  EXPECT_EQ(tracked.state, TrackingState::kSkipped);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 2.0) << "the pose is kept";
  EXPECT_EQ(tracked.counts.skipped, 1U);
  EXPECT_EQ(tracked.counts.tracked, 1U);
}

TEST_F(TrackerTest, IsLostAfterTheTimeAndShowsNoPoseThen) {
  auto tracker = make({result(1.0, 1.0), result(2.0, 50.0)});
  ASSERT_TRUE(tracker.start_at(*frame(milliseconds(0)), at_x(0.0)));
  EXPECT_EQ(tracker.process(frame(milliseconds(1999)))->state, TrackingState::kSkipped);
  const auto tracked = tracker.process(frame(milliseconds(2000))).value();
  EXPECT_EQ(tracked.state, TrackingState::kLost);
  EXPECT_FALSE(tracked.ct_from_depth);
  EXPECT_EQ(tracker.process(frame(milliseconds(3000)))->counts.lost, 1U)
      << "lost once, not each frame";
}

TEST_F(TrackerTest, ResumesWhenTheConstraintHoldsAgain) {
  auto tracker = make({result(1.0, 1.0), result(2.0, 50.0), result(3.0, 1.2)});
  ASSERT_TRUE(tracker.start_at(*frame(milliseconds(0)), at_x(0.0)));
  EXPECT_EQ(tracker.process(frame(milliseconds(5000)))->state, TrackingState::kLost);
  const auto tracked = tracker.process(frame(milliseconds(6000))).value();
  EXPECT_EQ(tracked.state, TrackingState::kTracking);
  EXPECT_DOUBLE_EQ(tracked.ct_from_depth->translation().x(), 3.0);
}

TEST_F(TrackerTest, ACoveredCameraIsASkippedFrame) {
  auto tracker = make({result(1.0, 1.0)});
  ASSERT_TRUE(tracker.start_at(*frame(milliseconds(0)), at_x(0.0)));
  EXPECT_EQ(tracker.process(frame(milliseconds(33), 0))->state, TrackingState::kSkipped);
}

TEST_F(TrackerTest, RefusesAStartThatDoesNotFitAndSaysByHowMuch) {
  auto tracker = make({result(1.0, 23.0, 0.31)});
  const auto started = tracker.start_at(*frame(milliseconds(0)), at_x(0.0));
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message, HasSubstr("31 %"));
  EXPECT_THAT(started.error().message, HasSubstr("residual 23.0 mm (limit 6.0 mm)"));
  EXPECT_EQ(tracker.process(frame(milliseconds(33)))->state, TrackingState::kWaiting);
}

TEST(TrackingOptions, NameTheValueAndTheLimit) {
  EXPECT_THAT(TrackingOptions{.residual_ratio = 1.0}.check().error().message,
              HasSubstr("residual_ratio must be above 1, got 1"));
  EXPECT_FALSE(TrackingOptions{.lost_after = milliseconds(0)}.check());
  EXPECT_FALSE(TrackingOptions{.start_min_explained = 1.5}.check());
}

}  // namespace
}  // namespace mor
