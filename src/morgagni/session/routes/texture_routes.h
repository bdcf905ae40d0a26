// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/session/texture_recorder.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// The fused texture over HTTP (docs/http-api.md).
[[nodiscard]] std::vector<HttpRoute> make_texture_routes(std::shared_ptr<TextureRecorder> recorder);

}  // namespace mor
