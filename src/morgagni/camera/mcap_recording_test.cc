// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/mcap_recording.h"

#include <csignal>
#include <cstdlib>
#include <thread>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/camera/testing/sample_recording.h"

namespace mor {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;
using internal::record_samples;
using internal::sample_calibration;
using internal::sample_frame;
using internal::sample_pose;

const McapRecorderOptions kLossless{.color = ColorCoding::kLossless};

class Mcap : public testing::Test {
 protected:
  Mcap() : home_(fs::temp_directory_path() / ("mor_mcap_" + std::to_string(getpid()))) {
    fs::remove_all(home_);
    fs::create_directories(home_);
  }
  ~Mcap() override { fs::remove_all(home_); }

  fs::path path(const std::string& name = "r.mcap") const { return home_ / name; }

  fs::path home_;
};

void expect_sample(const McapRecording& recording, std::size_t i) {
  const auto read = recording.read(i);
  ASSERT_TRUE(read) << read.error().message;
  const auto written = sample_frame(i);
  EXPECT_EQ((*read)->frame_id, i);
  EXPECT_EQ((*read)->depth_mm, written.depth_mm) << i;
  EXPECT_EQ((*read)->color, written.color) << i;
  EXPECT_EQ((*read)->device_time, written.device_time);
  EXPECT_EQ(recording.since_start(i), written.captured_at - sample_frame(0).captured_at);
  const auto pose = recording.pose(i).value().value();
  const auto found = sample_pose(i);
  EXPECT_EQ(pose.state, found.state);
  EXPECT_EQ(pose.is_held, found.is_held);
  EXPECT_EQ(pose.bound_mm, found.bound_mm);
  EXPECT_EQ(pose.doubts, found.doubts);
  EXPECT_EQ(pose.ct_from_depth->matrix(), found.ct_from_depth->matrix()) << "every bit";
}

TEST_F(Mcap, GivesBackWhatWasRecordedInAnyOrder) {
  ASSERT_TRUE(record_samples(path(), 50, kLossless));
  const auto recording = McapRecording::open(path());
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_TRUE(recording->is_complete());
  ASSERT_EQ(recording->size(), 50U);
  EXPECT_EQ(*recording->calibration(), *sample_calibration()) << "every bit";
  for (std::size_t i = 0; i < 50; ++i) expect_sample(*recording, i);
  for (const std::size_t i : {49U, 0U, 31U, 30U, 2U}) expect_sample(*recording, i);
  const auto age = std::chrono::system_clock::now().time_since_epoch() - recording->wall_time(0);
  EXPECT_LT(std::chrono::abs(age), std::chrono::minutes(1));
}

TEST_F(Mcap, JpegKeepsDepthAndLooksLikeTheColour) {
  ASSERT_TRUE(record_samples(path(), 3, {}));
  const auto frame = McapRecording::open(path())->read(1).value();
  const auto written = sample_frame(1);
  EXPECT_EQ(frame->depth_mm, written.depth_mm);
  EXPECT_NEAR(frame->color(10, 20).g, written.color(10, 20).g, 16);
}

TEST_F(Mcap, AFrameNeedsNoPoseAndNoDeviceClock) {
  {
    auto recorder = McapRecorder::create(path(), kLossless).value();
    auto frame = sample_frame(0);
    frame.device_time.reset();
    ASSERT_TRUE(recorder.add(frame));
    FoundPose lost;
    lost.state = "lost";
    frame.captured_at += std::chrono::milliseconds(1);
    ASSERT_TRUE(recorder.add(frame, lost));
    ASSERT_TRUE(recorder.finish());
    EXPECT_EQ(recorder.num_bytes(), fs::file_size(path()));
  }
  const auto recording = McapRecording::open(path()).value();
  EXPECT_FALSE(recording.pose(0).value());
  EXPECT_EQ(recording.pose(1).value()->state, "lost");
  EXPECT_FALSE(recording.pose(1).value()->ct_from_depth);
  EXPECT_FALSE(recording.read(0).value()->device_time);
}

TEST_F(Mcap, CutOffAnywhereItGivesEveryWholeChunk) {
  ASSERT_TRUE(record_samples(path(), 50, kLossless));  // 17 frames a chunk.
  const auto size = fs::file_size(path());
  std::size_t last = 50;
  for (auto cut = size; cut > 0; cut = cut > 997 ? cut - 997 : 0) {
    fs::resize_file(path(), cut);
    const auto recording = McapRecording::open(path());
    if (!recording) {
      EXPECT_LE(last, 17U) << cut << ": " << recording.error().message;
      continue;
    }
    ASSERT_LE(recording->size(), last);
    last = recording->size();
    EXPECT_TRUE(last == 50 || last % 17 == 0) << last;
    EXPECT_EQ(recording->is_complete(), cut == size);
    expect_sample(*recording, last - 1);
  }
  EXPECT_EQ(last, 17U);
}

TEST_F(Mcap, AfterKill9TheLastSecondAtMostIsLost) {
  int told[2] = {};
  ASSERT_EQ(pipe(told), 0);
  const pid_t child = fork();
  if (child == 0) {
    auto recorder = McapRecorder::create(path(), kLossless).value();
    for (std::uint64_t i = 0;; ++i) {
      if (!recorder.add(sample_frame(i), sample_pose(i))) _exit(1);
      if (write(told[1], &i, sizeof(i)) < 0) _exit(1);
    }
  }
  std::uint64_t written = 0;
  while (written < 200) ASSERT_EQ(read(told[0], &written, sizeof(written)), 8);
  kill(child, SIGKILL);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  close(told[1]);
  for (std::uint64_t more = 0; read(told[0], &more, sizeof(more)) == 8;) written = more;
  close(told[0]);
  const auto recording = McapRecording::open(path()).value();
  EXPECT_FALSE(recording.is_complete());
  EXPECT_GE(recording.size() + 30, written + 1);
  expect_sample(recording, recording.size() - 1);
}

TEST_F(Mcap, AFullDiskIsSaidAndWhatWasWrittenStays) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{200'000, 200'000};
    setrlimit(RLIMIT_FSIZE, &limit);
    auto recorder = McapRecorder::create(path(), kLossless).value();
    for (std::uint64_t i = 0; i < 10'000; ++i) {
      if (const auto added = recorder.add(sample_frame(i), sample_pose(i)); !added) {
        _exit(added.error().message.find("r.mcap: File too large") == std::string::npos ? 1 : 0);
      }
    }
    _exit(2);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_EQ(WEXITSTATUS(status), 0);
  const auto recording = McapRecording::open(path()).value();
  ASSERT_GE(recording.size(), 17U);
  expect_sample(recording, recording.size() - 1);
}

TEST_F(Mcap, TheDiskIsNotFilledToItsEnd) {
  auto recorder = McapRecorder::create(path(), {.min_free_bytes = std::uint64_t{1} << 60U}).value();
  std::uint64_t i = 0;
  auto added = recorder.add(sample_frame(i));
  while (added) added = recorder.add(sample_frame(++i));
  EXPECT_THAT(added.error().message, AllOf(HasSubstr("r.mcap"), HasSubstr("disk is full")));
  EXPECT_EQ(recorder.num_frames(), 0U);
  EXPECT_TRUE(recorder.finish());
  EXPECT_THAT(McapRecording::open(path()).error().message, HasSubstr("no frames"));
}

TEST_F(Mcap, SaysWhatCannotBeRecorded) {
  ASSERT_TRUE(record_samples(path(), 1, {}));
  EXPECT_THAT(McapRecorder::create(path(), {}).error().message, HasSubstr("exists"));
  EXPECT_THAT(McapRecorder::create(home_ / "no/r.mcap", {}).error().message, HasSubstr("No such"));
  EXPECT_THAT(McapRecorder::create(path("q"), {.jpeg_quality = 0}).error().message,
              HasSubstr("[1, 100], got 0"));
  auto recorder = McapRecorder::create(path("b.mcap"), {}).value();
  const auto error = [&](const RgbdFrame& frame) {
    const auto added = recorder.add(frame);
    return added ? "added" : added.error().message;
  };
  ASSERT_EQ(error(sample_frame(1)), "added");
  EXPECT_THAT(error(sample_frame(1)), HasSubstr("before the last"));
  auto frame = sample_frame(2);
  frame.depth_mm = Image<std::uint16_t>(31, 24);
  EXPECT_THAT(error(frame), HasSubstr("size"));
  frame = sample_frame(2);
  auto calibration = *frame.calibration;
  calibration.color_from_depth.translation().x() += 1e-9;
  frame.calibration = std::make_shared<const RgbdCalibration>(calibration);
  EXPECT_THAT(error(frame), HasSubstr("calibration changed"));
  frame.calibration.reset();
  EXPECT_THAT(error(frame), HasSubstr("without calibration"));
  EXPECT_EQ(error(sample_frame(2)), "added");
  ASSERT_TRUE(recorder.finish());
  EXPECT_EQ(McapRecording::open(path("b.mcap"))->size(), 2U);
}

TEST_F(Mcap, PlaysAsACamera) {
  ASSERT_TRUE(record_samples(path(), 5, kLossless));
  const auto camera =
      open_camera("mcap:" + path().string() + ",loop=1,speed=full", nullptr).value();
  EXPECT_EQ(camera->calibration(), *sample_calibration());
  const auto first = camera->next_frame({}).value();
  for (std::uint64_t i = 1; i < 12; ++i) {
    const auto frame = camera->next_frame({}).value();
    EXPECT_EQ(frame->frame_id, i % 5);
    EXPECT_EQ(frame->depth_mm, sample_frame(i % 5).depth_mm);
    EXPECT_EQ(frame->captured_at - first->captured_at, i * std::chrono::nanoseconds(33'333'333));
  }
  EXPECT_THAT(open_camera("mcap:", nullptr).error().message, HasSubstr("needs a file"));
  EXPECT_THAT(open_camera("mcap:/nowhere.mcap", nullptr).error().message, HasSubstr("/nowhere"));
}

}  // namespace
}  // namespace mor
