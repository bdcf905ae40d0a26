// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/result.h"

namespace mor::dimse {

/// Files in PEM; empty: none.
struct TlsFiles {
  bool enabled = false;
  std::string ca;
  std::string certificate;
  std::string key;
};

/// What the parent wants of this process.
struct Task {
  std::string name;
  std::string host;
  std::uint16_t port = 0;
  std::string called_aet;
  std::string calling_aet;
  TlsFiles tls;
  std::uint32_t timeout_s = 30;  ///< Without a word from the peer.

  std::string level;                        ///< "STUDY", "SERIES", "IMAGE".
  std::map<std::string, std::string> keys;  ///< Tag ("0020000D") -> what is asked for.
  int max_matches = 0;

  std::string folder;  ///< What is received goes there.
  std::string parts;   ///< What is not whole yet lies here; on the same disk.
  std::uint64_t max_object_bytes = 0;
  std::uint64_t min_free_bytes = 0;
  std::vector<std::string> accepted_callers;  ///< Empty: any.
  bool any_called_aet = false;
};

/// @errors kInvalidArgument: it is not JSON, or a member has the wrong type.
[[nodiscard]] Result<Task> parse_task(std::string_view json);

}  // namespace mor::dimse
