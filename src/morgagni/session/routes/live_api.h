// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "morgagni/calibration/calibration_origin.h"
#include "morgagni/session/live_loop.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// What the page may ask and command, as JSON over HTTP (docs/http-api.md).
[[nodiscard]] std::vector<HttpRoute> make_live_routes(std::shared_ptr<const Case> body,
                                                      std::shared_ptr<LiveLoop> loop,
                                                      const PlacementOptions& placement);

/// The status event: what the page shows beside the picture.
[[nodiscard]] std::string status_json(const LiveStatus& status,
                                      const ViewSettings& view,
                                      const LiveServerStats& stream,
                                      std::string_view method,
                                      std::string_view camera,
                                      const CalibrationOrigin& calibration);

}  // namespace mor
