// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "morgagni/camera/recording.h"
#include "morgagni/camera/testing/sample_recording.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Forty frames, 5 and 15 ms apart by turns.
class UnevenRecording : public Recording {
 public:
  std::size_t size() const override { return 40; }
  std::chrono::nanoseconds since_start(std::size_t i) const override {
    return milliseconds(10 * i + (i % 2 == 1 ? 5 : 0));
  }
  const std::shared_ptr<const RgbdCalibration>& calibration() const override {
    return calibration_;
  }
  Result<std::shared_ptr<const RgbdFrame>> read(std::size_t i) const override {
    return std::make_shared<const RgbdFrame>(internal::sample_frame(i));
  }

 private:
  std::shared_ptr<const RgbdCalibration> calibration_ = internal::sample_calibration();
};

/// Plays it in real time to a caller who needs so long for a frame. What is asked of it holds on
/// any machine: a busy one is a slow caller.
/// @return The number of frames that came.
int play(milliseconds work) {
  const UnevenRecording same;
  const auto camera = play_recording(std::make_unique<UnevenRecording>(), {});
  std::optional<Clock::time_point> started_at;
  int num_frames = 0;
  std::uint64_t least = 0;
  while (true) {
    const auto asked_at = Clock::now();
    const auto frame = camera->next_frame({}).value();
    if (!frame) break;
    const auto id = frame->frame_id;
    EXPECT_GE(id, least) << "in order and none twice";
    least = id + 1;
    if (!started_at) started_at = frame->captured_at - same.since_start(id);
    EXPECT_EQ(frame->captured_at, *started_at + same.since_start(id));
    EXPECT_GE(Clock::now(), frame->captured_at) << "not before it is due";
    if (least < same.size()) {
      EXPECT_GT(*started_at + same.since_start(least), asked_at) << "the newest that is due";
    }
    ++num_frames;
    std::this_thread::sleep_for(work);
  }
  EXPECT_EQ(least, same.size()) << "the last one always comes";
  return num_frames;
}

TEST(RecordingPlayer, InRealTimeEachFrameComesWhenItIsDue) {
  EXPECT_GE(play(milliseconds(0)), 2);
}

TEST(RecordingPlayer, InRealTimeASlowCallerMissesFrames) {
  // 395 ms of them, 40 ms each.
  EXPECT_LE(play(milliseconds(40)), 12);
}

}  // namespace
}  // namespace mor
