// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/session/self_calibrator.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// The sensor's error as it is found on the CT skin, and its removal (docs/http-api.md).
[[nodiscard]] std::vector<HttpRoute> make_self_calibration_routes(
    std::shared_ptr<SelfCalibrator> calibrator);

}  // namespace mor
