// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "morgagni/camera/recording_thread.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// Records what a live session sees and finds, while it is asked to: each tracked frame with its
/// pose, into an MCAP file of its own in a folder. @threads Any.
class SessionRecorder {
 public:
  /// @param folder  Made when the first recording begins.
  /// @param about  Kept in each recording: case, camera.
  SessionRecorder(std::filesystem::path folder,
                  std::vector<std::pair<std::string, std::string>> about)
      : folder_(std::move(folder)), about_(std::move(about)) {}

  struct State {
    bool is_recording = false;
    std::string file;  ///< Of the recording that goes on, or of the last one. Empty: none yet.
    RecordingProgress progress;
  };

  /// @errors kInvalidArgument (one goes on already), kIo.
  [[nodiscard]] Result<State> start(ColorCoding color);
  /// Waits until all is on disk: up to two seconds of frames. @errors kInvalidArgument: none goes
  /// on.
  [[nodiscard]] Result<State> stop();
  [[nodiscard]] State state() const;

  /// Takes a frame if a recording goes on. Returns at once.
  void see(const TrackedFrame& tracked);

 private:
  [[nodiscard]] State state_locked() const;

  const std::filesystem::path folder_;
  const std::vector<std::pair<std::string, std::string>> about_;
  mutable std::mutex mutex_;  ///< Guards everything down to the end.
  std::shared_ptr<RecordingThread> thread_;
  State last_;
  std::shared_ptr<const FixedSurface> skin_;  ///< Of the newest frame.
};

}  // namespace mor
