// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "morgagni/camera/range_camera.h"

namespace mor::internal {

/// Whether a frame may follow in a recording.
/// @param calibration  Of the recording so far; null: this is its first frame.
/// @errors kInvalidArgument: a frame without calibration or with another one, of another size than
///         it says, or not later than the last.
[[nodiscard]] Result<void> check_recordable(const RgbdFrame& frame,
                                            const RgbdCalibration* calibration,
                                            std::chrono::steady_clock::time_point last_captured_at);

}  // namespace mor::internal
