// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "morgagni/documentation/finding.h"

namespace mor::internal {

/// All of a finding, as findings.json and the viewer hold it.
[[nodiscard]] nlohmann::ordered_json to_json(const Finding& finding);

}  // namespace mor::internal
