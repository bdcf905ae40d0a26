// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "morgagni/camera/range_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/folder_lock.h"
#include "morgagni/stream/live_server.h"

namespace mor {

enum class RecorderState : std::uint8_t { kIdle, kRecording, kFinishing };

struct RecorderStatus {
  RecorderState state = RecorderState::kIdle;
  VideoStatus video;      ///< Of the one that is recorded.
  std::string name;       ///< Of the video that is recorded, or of the last one; "2026-...webm".
  std::string last_said;  ///< How the last one ended, in a sentence. Empty: nothing to say.
  bool last_failed = false;
};

/// Videos of what is streamed, in the case's folder `videos`.
///
/// While it is recorded a video has `.part` in its name. At its end it gets its own name, and
/// beside the poses (NAME.jsonl) a NAME.json with who, what and when, and the hashes. What a killed
/// program left unfinished is finished when the next one starts, and says so.
/// @threads Any; the long work is done in a thread of its own.
class Recorder {
 public:
  /// Asked for when a video is finished. It must not change while one is recorded.
  using InUse = std::function<std::shared_ptr<const RgbdCalibration>()>;
  using Skin = std::function<std::shared_ptr<const FixedSurface>()>;

  Recorder(std::shared_ptr<const Case> body, InUse calibration, Skin skin, std::string camera_name);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Finishes what is left over, and is ready for videos from then on.
  /// @param server  Lives until close().
  void run(LiveServer& server);
  /// Ends and finishes a video that is recorded. Waits.
  void close();

  /// @errors kInvalidArgument: one is recorded or finished just now, or another Morgagni records;
  /// kIo.
  [[nodiscard]] Result<void> start();
  /// Returns at once; the video is finished meanwhile. @errors kInvalidArgument: none is recorded.
  [[nodiscard]] Result<void> stop();
  [[nodiscard]] RecorderStatus status() const;

 private:
  void work(std::stop_token stop);
  void finish_left_over();
  void finish(const std::string& name, const std::string& problem, bool is_left_over);
  /// What a video at its end leaves beside it. @return Its length in seconds.
  struct Ended {
    std::filesystem::path video;
    std::filesystem::path pictures;
    std::uint64_t num_pictures = 0;
    std::string how;
  };
  [[nodiscard]] Result<double> write_evidence(const std::string& name, const Ended& ended) const;
  [[nodiscard]] Result<double> finish_files(const std::string& name,
                                            const std::string& how,
                                            bool is_broken) const;
  [[nodiscard]] Result<void> take_folder();

  const std::shared_ptr<const Case> body_;
  LiveServer* server_ = nullptr;  ///< From run() to close().
  const InUse calibration_;
  const Skin skin_;  ///< To which the pictures' frames are registered.
  const std::string camera_name_;
  const std::filesystem::path folder_;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  RecorderStatus status_;
  bool stop_wanted_ = false;
  std::optional<FolderLock> lock_;

  std::jthread thread_;
};

}  // namespace mor
