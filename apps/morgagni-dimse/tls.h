// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "morgagni/core/result.h"

#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmtls/tlslayer.h"
#include "task.h"

namespace mor::dimse {

/// TLS 1.2 or newer by the profile of BCP 195. Null where the task wants none.
///
/// A requestor trusts what `ca` vouches for, if the certificate is of `host`, a name or an IP
/// address. An acceptor with `ca` wants such a certificate of who
/// calls; one without takes anybody and only keeps what is sent from others' eyes.
/// @errors kInvalidArgument: a file is missing, broken or does not fit; the sentence names it.
[[nodiscard]] Result<std::unique_ptr<DcmTLSTransportLayer>> make_tls(const TlsFiles& files,
                                                                     T_ASC_NetworkRole role,
                                                                     const std::string& host = {});

/// Why the other side's certificate was refused, the last time one was. Empty: none was.
[[nodiscard]] std::string refused_certificate();

}  // namespace mor::dimse
