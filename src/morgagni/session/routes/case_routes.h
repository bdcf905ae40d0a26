// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/registration/start.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// What the case is, and its skin to be looked at and tapped.
[[nodiscard]] std::vector<HttpRoute> make_case_routes(std::shared_ptr<const Case> body,
                                                      const PlacementOptions& placement);

}  // namespace mor
