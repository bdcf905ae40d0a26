// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// Documents of the case for the page: asked for, made in a thread of their own below
/// CASE/documents, offered as downloads. The thread ends with the routes.
/// @param web_root  Where the built viewer page lies.
[[nodiscard]] std::vector<HttpRoute> make_documents_routes(std::shared_ptr<const Case> body,
                                                           const std::filesystem::path& web_root);

}  // namespace mor
