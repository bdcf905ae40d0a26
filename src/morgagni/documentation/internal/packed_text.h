// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace mor::internal {

[[nodiscard]] std::string base64(std::string_view bytes);

/// RFC 1952, as browsers unpack it.
[[nodiscard]] std::string gzip(std::string_view bytes);

}  // namespace mor::internal
