// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/session/live_loop.h"

namespace mor {

/// What is seen, and what lies under a finger on it.
[[nodiscard]] std::vector<HttpRoute> make_view_routes(std::shared_ptr<LiveLoop> loop);

}  // namespace mor
