// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/session/recorder.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// The AR video over HTTP (docs/http-api.md).
[[nodiscard]] std::vector<HttpRoute> make_recorder_routes(std::shared_ptr<Recorder> recorder);

}  // namespace mor
