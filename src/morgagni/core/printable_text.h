// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace mor {

/// Text from outside (a file's words, its name, what a peer sent) as one line of valid UTF-8 that a
/// terminal, JSON and a page can show: what is no UTF-8 is taken for Latin-1, a character that was
/// cut at the end is left out, and control characters, escape sequences and marks that turn the
/// direction of what follows become blanks.
[[nodiscard]] std::string printable_text(std::string_view text);

}  // namespace mor
