// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "morgagni/camera/range_camera.h"

namespace mor {

/// As open_camera() of range_camera.h, for whoever can be asked to stop: `push:` waits until a
/// device has pushed a frame. @errors Besides, kCancelled: `stop` was requested before.
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> open_camera(
    const std::string& name,
    std::shared_ptr<const TriangleMesh> skin,
    std::stop_token stop,
    const KnownCalibration& known = {});

}  // namespace mor
