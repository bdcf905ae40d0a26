// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// Told, in a sentence, what a camera is waited for; each time that changes. Any thread.
using SayWaiting = std::function<void(const std::string& sentence)>;

/// Whether the name is that of a device, which may be plugged in later and may be calibrated; no
/// recording and no simulation.
[[nodiscard]] bool is_device_camera(std::string_view name);

/// A camera's name as others may read it: without the value of `token=`.
[[nodiscard]] std::string shown_camera_name(std::string name);

/// As open_camera() of range_camera.h, for whoever can be asked to stop: `push:` waits until a
/// device has pushed a frame.
/// Devices take `,calibration=FILE` and, for the id under which one is kept, `,device=ID` as well.
/// @param say  Where given, any device is waited for that is not there or cannot be opened yet.
/// @errors Besides, kCancelled: `stop` was requested before.
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_camera(
    const std::string& name,
    std::shared_ptr<const TriangleMesh> skin,
    std::stop_token stop,
    const KnownCalibration& known = {},
    const SayWaiting& say = {});

}  // namespace mor
