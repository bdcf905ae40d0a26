// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/recording_thread.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/camera/mcap_recording.h"
#include "morgagni/camera/testing/sample_recording.h"

namespace mor {
namespace {

using testing::HasSubstr;

class RecordingThreadTest : public testing::Test {
 protected:
  RecordingThreadTest()
      : path_(std::filesystem::temp_directory_path() /
              ("mor_thread_" + std::to_string(getpid()) + ".mcap")) {
    std::filesystem::remove(path_);
  }
  ~RecordingThreadTest() override { std::filesystem::remove(path_); }

  static std::shared_ptr<const RgbdFrame> frame(std::uint64_t id) {
    return std::make_shared<const RgbdFrame>(internal::sample_frame(id));
  }

  std::filesystem::path path_;
};

TEST_F(RecordingThreadTest, NoneOfThePutFramesIsLost) {
  RecordingThread thread(McapRecorder::create(path_, {}).value());
  for (std::uint64_t i = 0; i < 300; ++i) thread.put(frame(i), internal::sample_pose(i));
  const auto progress = thread.finish();
  EXPECT_FALSE(progress.error);
  EXPECT_EQ(progress.num_frames, 300U);
  EXPECT_EQ(progress.num_dropped, 0U);
  EXPECT_EQ(progress.duration, 299 * std::chrono::nanoseconds(33'333'333));
  EXPECT_EQ(progress.num_bytes, std::filesystem::file_size(path_));
  EXPECT_EQ(McapRecording::open(path_)->size(), 300U);
  thread.put(frame(300));  // Too late, and says nothing.
  EXPECT_EQ(thread.finish().num_frames, 300U);
}

TEST_F(RecordingThreadTest, ACameraThatStopsLeavesNoFrameInMemory) {
  RecordingThread thread(McapRecorder::create(path_, {}).value());
  const auto num_readable = [&] {
    const auto recording = McapRecording::open(path_);
    return recording ? recording->size() : 0;
  };
  // Less than a chunk, and again after the silence.
  for (const std::uint64_t count : {5U, 9U}) {
    for (auto i = thread.progress().num_frames; i < count; ++i) thread.put(frame(i));
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (num_readable() < count && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(num_readable(), count) << "without finish()";
  }
  EXPECT_EQ(thread.finish().num_frames, 9U);
  EXPECT_EQ(num_readable(), 9U);
}

TEST_F(RecordingThreadTest, OfferedFramesAreWrittenOrCounted) {
  RecordingThread thread(McapRecorder::create(path_, {.color = ColorCoding::kLossless}).value());
  for (std::uint64_t i = 0; i < 2000; ++i) thread.offer(frame(i));
  const auto progress = thread.finish();
  EXPECT_EQ(progress.num_frames + progress.num_dropped, 2000U);
  EXPECT_EQ(McapRecording::open(path_)->size(), progress.num_frames);
}

TEST_F(RecordingThreadTest, WhoWaitsForRoomIsLetGoByAnError) {
  RecordingThread thread(
      McapRecorder::create(path_, {.min_free_bytes = std::uint64_t{1} << 60U}).value());
  // The disk is found full with the first chunk, while the queue is full too.
  for (std::uint64_t i = 0; i < 500; ++i) thread.put(frame(i));
  const auto progress = thread.finish();
  ASSERT_TRUE(progress.error);
  EXPECT_THAT(progress.error->message, HasSubstr("disk is full"));
  EXPECT_EQ(progress.num_frames, 0U);
}

TEST_F(RecordingThreadTest, FramesThatTheEndCannotWriteAreNotCounted) {
  RecordingThread thread(
      McapRecorder::create(path_, {.min_free_bytes = std::uint64_t{1} << 60U}).value());
  for (std::uint64_t i = 0; i < 3; ++i) thread.put(frame(i));
  const auto progress = thread.finish();
  ASSERT_TRUE(progress.error);
  EXPECT_EQ(progress.num_frames, 0U);
}

TEST_F(RecordingThreadTest, AnErrorEndsItAndIsKept) {
  RecordingThread thread(McapRecorder::create(path_, {}).value());
  for (std::uint64_t i = 0; i < 3; ++i) thread.put(frame(i));
  thread.put(frame(1));
  for (std::uint64_t i = 4; i < 100; ++i) thread.put(frame(i));
  const auto progress = thread.finish();
  ASSERT_TRUE(progress.error);
  EXPECT_THAT(progress.error->message, HasSubstr("before the last"));
  EXPECT_EQ(McapRecording::open(path_)->size(), progress.num_frames);
  EXPECT_GE(progress.num_frames, 3U);
}

}  // namespace
}  // namespace mor
