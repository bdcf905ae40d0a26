// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/session/findings_desk.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// Findings over HTTP (docs/http-api.md).
[[nodiscard]] std::vector<HttpRoute> make_findings_routes(std::shared_ptr<FindingsDesk> desk);

}  // namespace mor
