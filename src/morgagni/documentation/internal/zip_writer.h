// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "morgagni/core/result.h"

namespace mor::internal {

struct ZipPart {
  std::string name;
  std::string bytes;
};

/// A ZIP file in memory (libzip). @errors kInternal.
[[nodiscard]] Result<std::string> zip(std::span<const ZipPart> parts);

}  // namespace mor::internal
