// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "morgagni/evaluation/studies.h"

namespace mor {

/// The report to read: what is simulated and what that leaves out, tables beside the paper's
/// printed figures, the plots by their file names.
/// @param machine  What the times were measured on, a line.
[[nodiscard]] std::string to_markdown(const StudiesReport& report, const std::string& machine);

}  // namespace mor
