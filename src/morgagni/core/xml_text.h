// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace mor {

/// People's words as XML may hold them, in text and attributes: control characters are dropped,
/// bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string xml_text(std::string_view text);

/// Bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string valid_utf8(std::string_view text);

}  // namespace mor
