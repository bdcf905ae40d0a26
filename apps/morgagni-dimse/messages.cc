// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "messages.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "morgagni/pacs/dimse_protocol.h"

namespace mor::dimse {
namespace {

using Json = nlohmann::json;

/// Bytes that are no UTF-8 become a sign that says so.
void say(const Json& event) {
  const auto line = event.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  std::fwrite(line.data(), 1, line.size(), stdout);
  std::fflush(stdout);
}

}  // namespace

void say_match(const Tags& tags) {
  say({{kMatch, tags}});
}

void say_stored(std::string_view file, std::uint64_t bytes, const Tags& tags) {
  say({{kStored, {{"file", file}, {"bytes", bytes}, {"tags", tags}}}});
}

void say_caller(std::string_view aet) {
  say({{kCaller, aet}});
}

void say_weakness(std::string_view sentence) {
  say({{kWeakness, sentence}});
}

void say_refused(std::string_view why) {
  say({{kRefused, why}});
}

void say_done(int num_failed) {
  say({{kDone, num_failed}});
}

void say_failed(const Error& error) {
  say({{kFailed, error.message}, {"code", static_cast<int>(error.code)}});
}

}  // namespace mor::dimse
