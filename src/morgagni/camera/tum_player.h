// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/camera/range_camera.h"
#include "morgagni/camera/tum_recording.h"

namespace mor {

struct TumPlayerOptions {
  bool is_looped = false;
  bool is_real_time = true;  ///< By the recording's stamps; otherwise as fast as it is asked.
};

/// A recording as a camera. In real time a slow caller misses frames, as it would live.
/// `captured_at` is when the frame was due.
[[nodiscard]] std::unique_ptr<RangeCamera> play_recording(TumRecording recording,
                                                          const TumPlayerOptions& options);

}  // namespace mor
