// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/dimse_talk.h"

#include <cstdint>
#include <mutex>

#include <nlohmann/json.hpp>

#include "morgagni/core/log.h"
#include "morgagni/pacs/dimse_protocol.h"

namespace mor::internal {
namespace {

using Json = nlohmann::json;

constexpr int kMaxDepth = 8;

TagValues tags_of(const Json& json) {
  TagValues tags;
  for (const auto& [name, value] : json.items())
    if (value.is_string()) tags[name] = value.get<std::string>();
  return tags;
}

ErrorCode code_of(const Json& json) {
  const auto code = json.find("code");
  if (code == json.end() || !code->is_number_integer()) return ErrorCode::kIo;
  const auto number = code->get<std::int64_t>();
  const bool known = number >= 0 && number <= static_cast<int>(ErrorCode::kInternal);
  return known ? static_cast<ErrorCode>(number) : ErrorCode::kIo;
}

/// Discarded where it is no JSON, or nested deeper than the protocol is.
Json parsed(std::string_view line) {
  bool is_too_deep = false;
  const auto judge = [&](int depth, Json::parse_event_t /*event*/, Json& /*value*/) {
    is_too_deep = is_too_deep || depth > kMaxDepth;
    return !is_too_deep;
  };
  auto json = Json::parse(line, judge, /*allow_exceptions=*/false);
  return is_too_deep ? Json(Json::value_t::discarded) : json;
}

}  // namespace

void DimseTalk::hear_line(std::string_view line) {
  const Json json = parsed(line);
  if (!json.is_object()) {
    is_broken_ = true;
  } else if (json.contains(dimse::kMatch)) {
    if (events_.match) events_.match(tags_of(json[dimse::kMatch]));
  } else if (json.contains(dimse::kStored)) {
    const auto& stored = json[dimse::kStored];
    if (events_.stored)
      events_.stored(stored.at("file").get<std::string>(), tags_of(stored.at("tags")));
  } else if (json.contains(dimse::kCaller)) {
    if (events_.caller) events_.caller(terminal_text(json[dimse::kCaller].get<std::string>()));
  } else if (json.contains(dimse::kRefused)) {
    if (events_.refused) events_.refused(terminal_text(json[dimse::kRefused].get<std::string>()));
  } else if (json.contains(dimse::kWeakness)) {
    const auto sentence = terminal_text(json[dimse::kWeakness].get<std::string>());
    static std::once_flag told;  // It is the machine's, not the peer's.
    std::call_once(told, [&] { log::warn("{}", sentence); });
  } else if (json.contains(dimse::kFailed)) {
    outcome_ = make_error(code_of(json), terminal_text(json[dimse::kFailed].get<std::string>()));
  } else if (const auto& done = json.at(dimse::kDone); done.is_number_integer()) {
    outcome_ = done.get<int>();
  } else {
    is_broken_ = true;
  }
}

void DimseTalk::hear(std::string_view bytes) {
  pending_ += bytes;
  std::size_t start = 0;
  for (std::size_t end; !is_broken_ && (end = pending_.find('\n', start)) != std::string::npos;
       start = end + 1) {
    try {
      hear_line(std::string_view(pending_).substr(start, end - start));
    } catch (const Json::exception&) {
      is_broken_ = true;
    }
  }
  pending_.erase(0, start);
  is_broken_ = is_broken_ || pending_.size() > dimse::kMaxLineBytes;
}

}  // namespace mor::internal
