// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/session_recorder.h"

#include <ctime>

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/session/evidence_json.h"
#include "morgagni/tracking/error_bound.h"

namespace mor {
namespace {

/// "2026-11-26_17-05-33.mcap", local time; sorts by time and is a file name everywhere. A second
/// one in the same second gets a number.
std::string free_file_name(const std::filesystem::path& folder) {
  const auto name = fmt::format("{:%Y-%m-%d_%H-%M-%S}", fmt::localtime(std::time(nullptr)));
  std::string numbered = name + ".mcap";
  for (int i = 2; std::filesystem::exists(folder / numbered); ++i) {
    numbered = fmt::format("{}_{}.mcap", name, i);
  }
  return numbered;
}

FoundPose found_pose(const TrackedFrame& tracked) {
  FoundPose pose{.state = std::string(to_string(tracked.state)),
                 .ct_from_depth = tracked.ct_from_depth,
                 .is_held = tracked.is_held};
  // In the middle of the skin that was seen.
  if (tracked.ct_from_depth && tracked.covariance) {
    pose.bound_mm = error_bound_mm(*tracked.covariance, tracked.covariance->pivot_mm);
  }
  for (const auto doubt : tracked.doubts) {
    if (!pose.doubts.empty()) pose.doubts += ", ";
    pose.doubts += to_string(doubt);
  }
  return pose;
}

}  // namespace

SessionRecorder::State SessionRecorder::state_locked() const {
  if (!thread_) return last_;
  State state = last_;
  state.progress = thread_->progress();
  // One that failed has ended, whether or not somebody said stop.
  state.is_recording = !state.progress.error;
  return state;
}

SessionRecorder::State SessionRecorder::state() const {
  const std::lock_guard lock(mutex_);
  return state_locked();
}

Result<SessionRecorder::State> SessionRecorder::start(ColorCoding color) {
  const std::lock_guard lock(mutex_);
  if (state_locked().is_recording) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} is being recorded: stop it first", last_.file));
  }
  thread_.reset();
  std::error_code status;
  std::filesystem::create_directories(folder_, status);
  if (status) {
    return make_error(ErrorCode::kIo, fmt::format("{}: {}", folder_.string(), status.message()));
  }
  const auto name = free_file_name(folder_);
  // It stays the same while the recording goes on.
  auto about = about_;
  about.emplace_back("registered to", evidence::skin_words(skin_));
  MOR_TRY(auto recorder,
          McapRecorder::create(folder_ / name, {.color = color, .about = std::move(about)}));
  thread_ = std::make_shared<RecordingThread>(std::move(recorder));
  last_ = {.is_recording = true, .file = name, .progress = {}};
  return state_locked();
}

Result<SessionRecorder::State> SessionRecorder::stop() {
  std::shared_ptr<RecordingThread> thread;
  {
    const std::lock_guard lock(mutex_);
    thread = std::exchange(thread_, nullptr);
  }
  if (!thread) {
    return make_error(ErrorCode::kInvalidArgument, "nothing is being recorded");
  }
  // Outside of the lock: the tracking must not wait for the disk.
  const auto progress = thread->finish();
  const std::lock_guard lock(mutex_);
  last_.is_recording = false;
  last_.progress = progress;
  return last_;
}

void SessionRecorder::see(const TrackedFrame& tracked) {
  const std::lock_guard lock(mutex_);
  skin_ = tracked.fixed;
  if (thread_) thread_->offer(tracked.frame, found_pose(tracked));
}

}  // namespace mor
