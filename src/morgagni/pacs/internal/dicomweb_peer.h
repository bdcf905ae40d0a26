// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {

/// QIDO-RS and WADO-RS (DICOM PS3.18). @errors kInvalidArgument: a TLS file.
[[nodiscard]] Result<std::unique_ptr<PacsPeer>> open_dicomweb_peer(const PacsAddress& address,
                                                                   const PacsOptions& options);

}  // namespace mor::internal
