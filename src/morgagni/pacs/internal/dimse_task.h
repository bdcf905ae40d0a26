// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {

/// What all tasks of morgagni-dimse have in common.
[[nodiscard]] inline nlohmann::json dimse_task(const char* name, const PacsOptions& options) {
  return {{"task", name},
          {"calling_aet", options.aet},
          {"timeout_s", options.timeout.count()},
          {"max_object_bytes", options.max_object_bytes},
          {"min_free_bytes", options.min_free_bytes}};
}

[[nodiscard]] inline nlohmann::json dimse_tls(const PacsTls& tls) {
  return {{"ca", tls.ca.string()},
          {"certificate", tls.certificate.string()},
          {"key", tls.key.string()}};
}

}  // namespace mor::internal
