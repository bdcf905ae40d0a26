// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/session/session_recorder.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// Records the session into the case's `recordings`.
[[nodiscard]] std::shared_ptr<SessionRecorder> make_session_recorder(
    const Case& body, const std::string& camera_name);

[[nodiscard]] std::vector<HttpRoute> make_recording_routes(
    std::shared_ptr<SessionRecorder> recorder);

}  // namespace mor
