// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "task.h"

#include <nlohmann/json.hpp>

namespace mor::dimse {

Result<Task> parse_task(std::string_view text) {
  try {
    const auto json = nlohmann::json::parse(text);
    Task task;
    task.name = json.at("task").get<std::string>();
    task.host = json.value("host", "");
    task.port = json.value("port", task.port);
    task.called_aet = json.value("called_aet", "");
    task.calling_aet = json.value("calling_aet", "");
    if (const auto tls = json.find("tls"); tls != json.end()) {
      task.tls = {true, tls->value("ca", ""), tls->value("certificate", ""), tls->value("key", "")};
    }
    task.timeout_s = json.value("timeout_s", task.timeout_s);
    task.level = json.value("level", "");
    task.keys = json.value("keys", task.keys);
    task.max_matches = json.value("max_matches", 0);
    task.folder = json.value("folder", "");
    task.parts = json.value("parts", task.folder);
    task.max_object_bytes = json.value("max_object_bytes", task.max_object_bytes);
    task.min_free_bytes = json.value("min_free_bytes", task.min_free_bytes);
    task.accepted_callers = json.value("accepted_callers", task.accepted_callers);
    task.any_called_aet = json.value("any_called_aet", false);
    return task;
  } catch (const nlohmann::json::exception& error) {
    return make_error(ErrorCode::kInvalidArgument, error.what());
  }
}

}  // namespace mor::dimse
