// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "morgagni/stream/live_server.h"

namespace mor {

/// The CTs of a case, and which one is shown. Another one is another session: whoever runs this one
/// is told.
struct CtChoice {
  std::vector<std::string> names;                       ///< Of those beside the first.
  std::string shown;                                    ///< Empty: the first.
  std::function<void(const std::string& name)> choose;  ///< Returns at once. None: no choice.
};

/// What docs/http-api.md says of several CTs.
[[nodiscard]] std::vector<HttpRoute> make_ct_routes(const CtChoice& cts);

}  // namespace mor
