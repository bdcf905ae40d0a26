// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/recording_thread.h"

#include <utility>

namespace mor {
namespace {

/// As long as a chunk: the camera has stopped, and nobody else would end the open one.
constexpr std::chrono::milliseconds kFlushAfter{500};
constexpr std::size_t kMaxWaiting = 60;  ///< Two seconds; 92 MB of 640x480 frames.

}  // namespace

RecordingThread::RecordingThread(McapRecorder recorder)
    : recorder_(std::move(recorder)), thread_([this] { write(); }) {}

RecordingThread::~RecordingThread() {
  finish();
}

void RecordingThread::offer(std::shared_ptr<const RgbdFrame> frame, std::optional<FoundPose> pose) {
  const std::lock_guard lock(mutex_);
  if (is_ending_ || progress_.error) return;
  if (waiting_.size() >= kMaxWaiting) {
    ++progress_.num_dropped;
    return;
  }
  waiting_.push_back({std::move(frame), std::move(pose)});
  filled_.notify_one();
}

void RecordingThread::put(std::shared_ptr<const RgbdFrame> frame, std::optional<FoundPose> pose) {
  std::unique_lock lock(mutex_);
  emptied_.wait(lock,
                [this] { return waiting_.size() < kMaxWaiting || is_ending_ || progress_.error; });
  if (is_ending_ || progress_.error) return;
  waiting_.push_back({std::move(frame), std::move(pose)});
  filled_.notify_one();
}

RecordingProgress RecordingThread::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

RecordingProgress RecordingThread::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  filled_.notify_one();
  emptied_.notify_all();
  if (thread_.joinable()) thread_.join();
  return progress();
}

void RecordingThread::write() {
  std::unique_lock lock(mutex_);
  while (true) {
    filled_.wait_for(lock, kFlushAfter, [this] { return !waiting_.empty() || is_ending_; });
    if (waiting_.empty() && is_ending_) break;
    if (waiting_.empty()) {
      lock.unlock();
      heed(recorder_.flush());
    } else {
      const auto item = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      emptied_.notify_one();
      write_one(item);
    }
    lock.lock();
    if (progress_.error) {
      waiting_.clear();
      emptied_.notify_all();
    }
  }
  lock.unlock();
  heed(recorder_.finish());
}

void RecordingThread::write_one(const Item& item) {
  const auto added = recorder_.add(*item.frame, item.pose);
  heed(added);
  if (!added) return;
  const std::lock_guard lock(mutex_);
  if (!first_captured_at_) first_captured_at_ = item.frame->captured_at;
  progress_.duration = item.frame->captured_at - *first_captured_at_;
}

void RecordingThread::heed(const Result<void>& written) {
  const std::lock_guard lock(mutex_);
  progress_.num_frames = recorder_.num_frames();
  progress_.num_bytes = recorder_.num_bytes();
  if (!written && !progress_.error) progress_.error = written.error();
}

}  // namespace mor
