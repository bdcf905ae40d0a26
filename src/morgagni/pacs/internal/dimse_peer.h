// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {

/// C-ECHO, C-FIND, C-GET and C-MOVE, each in a process of its own. @errors kNotFound: the program.
[[nodiscard]] Result<std::unique_ptr<PacsPeer>> open_dimse_peer(const PacsAddress& address,
                                                                const PacsOptions& options);

}  // namespace mor::internal
