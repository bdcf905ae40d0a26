// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/session/live_loop.h"

namespace mor {

/// Records the session into the case's `recordings`. Joins the loop's observers.
[[nodiscard]] std::vector<HttpRoute> make_recording_routes(const Case& body,
                                                           LiveLoop& loop,
                                                           const std::string& camera_name);

}  // namespace mor
