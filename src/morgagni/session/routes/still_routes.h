// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/documentation/still.h"
#include "morgagni/session/live_loop.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// What a still of this picture says. @param marks  As LiveLoop::Mark gave them.
[[nodiscard]] StillWords still_words(const Case& body,
                                     const ShownPicture& shown,
                                     const std::string& marks);

/// Stills, kept in the case's folder `pictures` (docs/http-api.md).
[[nodiscard]] std::vector<HttpRoute> make_still_routes(std::shared_ptr<const Case> body,
                                                       std::shared_ptr<const LiveLoop> loop);

}  // namespace mor
