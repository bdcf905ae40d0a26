// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// What was tracked live and recorded is tracked again from the recording: the same poses, every
// bit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/camera/mcap_recording.h"
#include "morgagni/camera/simulated_camera.h"
#include "morgagni/registration/testing/test_body.h"
#include "morgagni/tracking/tracker.h"

namespace mor {
namespace {

constexpr int kNumFrames = 40;

class ReplayTest : public testing::Test {
 protected:
  ReplayTest()
      : path_(std::filesystem::temp_directory_path() /
              ("mor_replay_" + std::to_string(getpid()) + ".mcap")) {
    std::filesystem::remove(path_);
  }
  ~ReplayTest() override { std::filesystem::remove(path_); }

  /// Tracks a camera from its first frame to its last, from a start near the body.
  std::vector<TrackedFrame> track(RangeCamera& camera, int num_frames) const {
    auto tracker = Tracker::create({},
                                   body_,
                                   BodySurfaceExtractor::create(camera.calibration().depth,
                                                                {.down_sampling = 1.5})
                                       .value(),
                                   make_fine_registration(body_, {}).value())
                       .value();
    std::vector<TrackedFrame> tracked;
    for (int i = 0; i < num_frames; ++i) {
      const auto frame = camera.next_frame({}).value();
      if (i == 0) {
        EXPECT_TRUE(tracker.start_at(frame, start_));
      }
      tracked.push_back(tracker.process(frame).value());
    }
    return tracked;
  }

  std::filesystem::path path_;
  std::shared_ptr<const FixedSurface> body_ = internal::bumpy_surface();
  Eigen::Isometry3d start_ = Eigen::Isometry3d::Identity();
};

/// Its calibration says that the depth needs correction, by another amount at each place.
std::shared_ptr<const RgbdCalibration> needing_correction(const RgbdCalibration& calibration) {
  auto corrected = std::make_shared<RgbdCalibration>(calibration);
  DepthCorrection correction{.columns = 2, .rows = 2};
  correction.control = {{.c0_mm = 3.3}, {.c1 = 0.004}, {.c2_per_mm = 3e-6}, {.c0_mm = -1.7}};
  correction.curve = {{700.0, 0.7}, {800.0, -0.4}};
  corrected->depth_correction = std::make_shared<const DepthCorrection>(correction);
  return corrected;
}

/// Not quite 30 a second: the tracker foresees the camera's way from the times between the frames.
class UnevenCamera : public RangeCamera {
 public:
  explicit UnevenCamera(const SimulatedCamera& camera)
      : camera_(camera), calibration_(needing_correction(camera.calibration())) {}

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token /*stop*/) override {
    auto frame = std::make_shared<RgbdFrame>(*camera_.frame_at(next_));
    now_ += std::chrono::nanoseconds(33'333'333 + 1'234'567 * static_cast<int>(next_ % 5));
    frame->captured_at = now_;
    frame->calibration = calibration_;
    ++next_;
    return frame;
  }
  const RgbdCalibration& calibration() const override { return *calibration_; }

 private:
  const SimulatedCamera& camera_;
  std::shared_ptr<const RgbdCalibration> calibration_;
  std::uint64_t next_ = 0;
  std::chrono::steady_clock::time_point now_ = std::chrono::steady_clock::now();
};

TEST_F(ReplayTest, FindsEveryBitOfTheLivePosesEachTime) {
  const auto skin = std::shared_ptr<const TriangleMesh>(body_, &body_->mesh);
  const auto simulated = SimulatedCamera::create(skin,
                                                 {.seed = 7,
                                                  .width_px = 320,
                                                  .height_px = 240,
                                                  .distance_mm = 750.0,
                                                  .is_real_time = false})
                             .value();
  start_ = simulated->ct_from_camera(0);
  UnevenCamera live(*simulated);
  const auto seen = track(live, kNumFrames);
  auto recorder = McapRecorder::create(path_, {.color = ColorCoding::kLossless}).value();
  for (const auto& frame : seen) {
    FoundPose pose{.state = std::string(to_string(frame.state)),
                   .ct_from_depth = frame.ct_from_depth,
                   .is_held = frame.is_held};
    ASSERT_TRUE(recorder.add(*frame.frame, pose));
  }
  ASSERT_TRUE(recorder.finish());

  const auto recording = McapRecording::open(path_).value();
  for (int round = 0; round < 2; ++round) {
    const auto player = open_camera("mcap:" + path_.string() + ",speed=full", nullptr).value();
    const auto again = track(*player, kNumFrames);
    for (std::size_t i = 0; i < again.size(); ++i) {
      ASSERT_EQ(again[i].state, seen[i].state) << "frame " << i;
      ASSERT_EQ(again[i].state, TrackingState::kTracking) << "frame " << i;
      EXPECT_EQ(again[i].ct_from_depth->matrix(), seen[i].ct_from_depth->matrix()) << "frame " << i;
      EXPECT_EQ(again[i].frame->color, seen[i].frame->color) << "frame " << i;
      EXPECT_EQ(again[i].frame->depth_mm, seen[i].frame->depth_mm) << "frame " << i;
      // The recording keeps what the sensor gave; the correction was applied to both.
      const auto& sensed = as_sensed(*again[i].frame).depth_mm;
      EXPECT_EQ(sensed, as_sensed(*seen[i].frame).depth_mm) << "frame " << i;
      EXPECT_EQ(sensed, simulated->frame_at(i)->depth_mm) << "frame " << i;
      EXPECT_NE(sensed, again[i].frame->depth_mm) << "frame " << i;
      const auto kept = recording.pose(i).value().value();
      EXPECT_EQ(kept.ct_from_depth->matrix(), seen[i].ct_from_depth->matrix()) << "frame " << i;
    }
    EXPECT_EQ(player->next_frame({}).value(), nullptr);
  }
}

}  // namespace
}  // namespace mor
