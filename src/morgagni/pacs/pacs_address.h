// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor {

/// Where a PACS is, in one form for all ways of talking to it:
///
///   https://HOST[:PORT]/PATH   DICOMweb (also http://)
///   dicom://AET@HOST[:PORT]    DICOM's own network protocol; port 104
///   dicoms://AET@HOST[:PORT]   the same over TLS; port 2762
struct PacsAddress {
  enum class Kind : std::uint8_t { kDicomweb, kDimse };

  Kind kind = Kind::kDicomweb;
  bool tls = false;
  std::string host;
  std::uint16_t port = 0;
  std::string aet;  ///< Of the peer; DIMSE only.
  std::string url;  ///< DICOMweb: without a slash at its end.
};

/// @errors kInvalidArgument: another scheme, no host, no AE title, a password in it.
[[nodiscard]] Result<PacsAddress> parse_pacs_address(std::string_view text);

/// 1 to 16 printable ASCII characters, none of them a backslash, and not blanks only.
/// @param name  For the sentence.
[[nodiscard]] Result<void> check_aet(std::string_view aet, std::string_view name);

/// "127.0.0.1", "::1", "localhost".
[[nodiscard]] bool is_loopback(std::string_view host);

}  // namespace mor
