// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// Frames on disk, in the order of time.
class Recording {
 public:
  virtual ~Recording() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;
  /// From the first frame to frame `i`.
  [[nodiscard]] virtual std::chrono::nanoseconds since_start(std::size_t i) const = 0;
  [[nodiscard]] virtual const std::shared_ptr<const RgbdCalibration>& calibration() const = 0;

  /// Frame `i`; its `frame_id` is `i`. @errors kIo, kInvalidArgument: damaged.
  [[nodiscard]] virtual Result<std::shared_ptr<const RgbdFrame>> read(std::size_t i) const = 0;

 protected:
  Recording() = default;
  Recording(const Recording&) = default;
  Recording& operator=(const Recording&) = default;
  Recording(Recording&&) = default;
  Recording& operator=(Recording&&) = default;
};

struct RecordingPlayerOptions {
  bool is_looped = false;
  bool is_real_time = true;  ///< By the recording's stamps; otherwise as fast as it is asked.
};

/// A recording as a camera. In real time a slow caller misses frames, as it would live, and
/// `captured_at` is when the frame was due. At full speed none is missed and the times between the
/// frames are the recording's, whatever the clock does: whoever tracks them finds the same poses
/// each time.
[[nodiscard]] std::unique_ptr<RangeCamera> play_recording(
    std::unique_ptr<const Recording> recording, const RecordingPlayerOptions& options);

}  // namespace mor
