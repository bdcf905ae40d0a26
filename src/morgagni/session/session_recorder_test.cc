// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/session_recorder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/camera/mcap_recording.h"
#include "morgagni/camera/testing/sample_recording.h"

namespace mor {
namespace {

using testing::HasSubstr;

class SessionRecorderTest : public testing::Test {
 protected:
  SessionRecorderTest()
      : home_(std::filesystem::temp_directory_path() / ("mor_session_" + std::to_string(getpid()))),
        recorder_(home_ / "recordings", {{"case", "sample"}}) {
    std::filesystem::remove_all(home_);
  }
  ~SessionRecorderTest() override { std::filesystem::remove_all(home_); }

  static TrackedFrame tracked(std::uint64_t id) {
    TrackedFrame result;
    result.frame = std::make_shared<const RgbdFrame>(internal::sample_frame(id));
    result.state = TrackingState::kUncertain;
    result.ct_from_depth = internal::sample_pose(id).ct_from_depth;
    result.is_held = true;
    result.doubts = {Doubt::kJump, Doubt::kResidual};
    PoseCovariance covariance;
    covariance.matrix.setIdentity();
    result.covariance = covariance;
    return result;
  }

  std::filesystem::path home_;
  SessionRecorder recorder_;
};

TEST_F(SessionRecorderTest, KeepsWhatIsSeenWhileItIsAskedTo) {
  recorder_.see(tracked(0));
  EXPECT_FALSE(std::filesystem::exists(home_)) << "nobody asked for it";
  EXPECT_FALSE(recorder_.state().is_recording);
  const auto begun = recorder_.start(ColorCoding::kLossless).value();
  EXPECT_TRUE(begun.is_recording);
  for (std::uint64_t i = 1; i < 21; ++i) recorder_.see(tracked(i));
  EXPECT_TRUE(recorder_.state().is_recording);
  const auto ended = recorder_.stop().value();
  recorder_.see(tracked(21));
  EXPECT_FALSE(ended.is_recording);
  EXPECT_EQ(ended.file, begun.file);
  EXPECT_EQ(ended.progress.num_frames, 20U);
  EXPECT_EQ(recorder_.state().file, begun.file);

  const auto recording = McapRecording::open(home_ / "recordings" / ended.file).value();
  ASSERT_EQ(recording.size(), 20U);
  EXPECT_EQ(recording.read(0).value()->depth_mm, internal::sample_frame(1).depth_mm);
  const auto pose = recording.pose(0).value().value();
  EXPECT_EQ(pose.state, "uncertain");
  EXPECT_TRUE(pose.is_held);
  EXPECT_EQ(pose.doubts, "jump, residual");
  EXPECT_EQ(pose.ct_from_depth->matrix(), tracked(1).ct_from_depth->matrix());
  // 95 % of the lengths of a standard normal vector in three dimensions.
  EXPECT_NEAR(pose.bound_mm.value(), 2.795, 0.03);
}

TEST_F(SessionRecorderTest, SaysWhyItCannotBeginOrEnd) {
  EXPECT_THAT(recorder_.stop().error().message, HasSubstr("nothing is being recorded"));
  ASSERT_TRUE(recorder_.start(ColorCoding::kJpeg));
  EXPECT_THAT(recorder_.start(ColorCoding::kJpeg).error().message, HasSubstr("stop it first"));
  ASSERT_TRUE(recorder_.stop());
  SessionRecorder nowhere("/dev/null/recordings", {});
  EXPECT_THAT(nowhere.start(ColorCoding::kJpeg).error().message, HasSubstr("/dev/null"));
}

TEST_F(SessionRecorderTest, OneThatFailedIsSaidAndAnotherCanBegin) {
  ASSERT_TRUE(recorder_.start(ColorCoding::kJpeg));
  recorder_.see(tracked(5));
  recorder_.see(tracked(3));
  while (recorder_.state().is_recording) std::this_thread::yield();
  EXPECT_THAT(recorder_.state().progress.error->message, HasSubstr("before the last"));
  const auto failed = recorder_.state().file;
  ASSERT_TRUE(recorder_.start(ColorCoding::kJpeg));
  EXPECT_TRUE(recorder_.state().is_recording);
  EXPECT_NE(recorder_.state().file, failed);
}

}  // namespace
}  // namespace mor
