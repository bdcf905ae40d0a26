// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "morgagni/core/result.h"
#include "morgagni/pacs/pacs_peer.h"

namespace CLI {
class App;
}

namespace mor {

/// What the user says of a PACS and of a study in it.
struct PeerArguments {
  std::string address;
  PacsOptions options;
  PacsFilter filter;
  std::filesystem::path password_file;
  std::filesystem::path token_file;
  int timeout_s = 30;
};

/// The address, who we are, TLS, and what is looked for.
void add_peer_options(CLI::App& command, PeerArguments& arguments);
/// --ca, --certificate, --key.
void add_tls_options(CLI::App& command, PacsTls& tls);
/// --max-object-mb, --min-free-mb.
void add_size_options(CLI::App& command,
                      std::uint64_t& max_object_bytes,
                      std::uint64_t& min_free_bytes);

/// The peer; password and token from their files, else from MORGAGNI_PACS_PASSWORD and
/// MORGAGNI_PACS_TOKEN. @errors As open_pacs_peer(); kNotFound, kIo: those files.
[[nodiscard]] Result<std::unique_ptr<PacsPeer>> open_peer(PeerArguments arguments);

/// "20260131  0815  Doe^Jane  CT\SR  Chest  1.2.3", for a terminal.
[[nodiscard]] std::string to_text(const PacsStudy& study);
[[nodiscard]] std::string to_text(const PacsSeries& series);

}  // namespace mor
