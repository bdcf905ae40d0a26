// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/session/live_loop.h"

namespace mor {

/// How the tracking begins: searched for, placed, or by landmarks.
[[nodiscard]] std::vector<HttpRoute> make_start_routes(std::shared_ptr<LiveLoop> loop,
                                                       const PlacementOptions& placement);

}  // namespace mor
