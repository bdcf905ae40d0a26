// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "morgagni/core/printable_text.h"
#include "morgagni/core/result.h"
#include "morgagni/core/xml_text.h"
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

/// As morgagni-dimse reads it.
/// @errors kInvalidArgument: a path or a name that is no UTF-8, which JSON cannot say.
[[nodiscard]] inline Result<std::string> dimse_text(const nlohmann::json& task) {
  const auto flat = task.flatten();
  for (const auto& value : flat) {
    const auto* text = value.get_ptr<const std::string*>();
    if (text == nullptr || valid_utf8(*text) == *text) continue;
    return make_error(ErrorCode::kInvalidArgument,
                      "\"" + printable_text(*text) + "\" is not UTF-8: name it otherwise");
  }
  return task.dump();
}

}  // namespace mor::internal
