// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "morgagni/camera/mcap_recorder.h"

namespace mor {

struct RecordingProgress {
  std::uint64_t num_frames = 0;
  std::uint64_t num_dropped = 0;         ///< Frames that the disk was too slow for.
  std::uint64_t num_bytes = 0;           ///< On disk.
  std::chrono::nanoseconds duration{0};  ///< First frame to last.
  std::optional<Error> error;            ///< Why it has ended before it should.
};

/// Packs and writes frames in a thread of its own, so that whoever has them never waits for a disk.
/// Half a second without a frame, and all there were are on disk.
class RecordingThread {
 public:
  explicit RecordingThread(McapRecorder recorder);
  /// finish(), its outcome unheard.
  ~RecordingThread();

  /// Takes a frame if fewer than two seconds of them wait; counts it as dropped otherwise. Returns
  /// at once. Nothing is taken after an error.
  void offer(std::shared_ptr<const RgbdFrame> frame, std::optional<FoundPose> pose = {});
  /// Takes a frame, and waits for room: for cameras that wait for their caller.
  void put(std::shared_ptr<const RgbdFrame> frame, std::optional<FoundPose> pose = {});

  [[nodiscard]] RecordingProgress progress() const;

  /// Writes what waits and ends the file. Again: the same.
  RecordingProgress finish();

 private:
  struct Item {
    std::shared_ptr<const RgbdFrame> frame;
    std::optional<FoundPose> pose;
  };

  void write();
  void write_one(const Item& item);
  void heed(const Result<void>& written);

  McapRecorder recorder_;     ///< The thread's alone.
  mutable std::mutex mutex_;  ///< Guards everything down to the next blank line.
  std::condition_variable filled_, emptied_;
  std::deque<Item> waiting_;
  RecordingProgress progress_;
  std::optional<std::chrono::steady_clock::time_point> first_captured_at_;
  bool is_ending_ = false;

  std::jthread thread_;
};

}  // namespace mor
