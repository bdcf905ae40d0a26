// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/multipart_reader.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <glib.h>
#include <libsoup/soup.h>
#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr std::size_t kMaxHeadBytes = 16384;
constexpr std::size_t kMaxBoundaryBytes = 70;
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kHeadEnd = "\r\n\r\n";

tl::unexpected<Error> broken(const char* why) {
  return make_error(ErrorCode::kIo, fmt::format("the answer is a broken multipart: {}", why));
}

}  // namespace

Result<std::string> multipart_boundary(const std::string& content_type) {
  const auto semicolon = content_type.find(';');
  const std::string type = content_type.substr(0, semicolon);
  if (g_ascii_strcasecmp(type.c_str(), "multipart/related") != 0) {
    return make_error(ErrorCode::kIo,
                      fmt::format("the answer is \"{}\", not multipart/related", type));
  }
  if (semicolon == std::string::npos) return broken("no boundary");
  const std::unique_ptr<GHashTable, decltype(&soup_header_free_param_list)> parameters(
      soup_header_parse_semi_param_list(content_type.c_str() + semicolon + 1),
      soup_header_free_param_list);
  const auto* boundary =
      static_cast<const char*>(g_hash_table_lookup(parameters.get(), "boundary"));
  if (boundary == nullptr) return broken("no boundary");
  std::string text(boundary);
  if (text.empty() || text.size() > kMaxBoundaryBytes) return broken("its boundary's length");
  return text;
}

MultipartReader::MultipartReader(const std::string& boundary, PartSink sink)
    : delimiter_(std::string(kLineEnd) + "--" + boundary),
      sink_(std::move(sink)),
      pending_(kLineEnd) {}  // The first delimiter may stand at the very beginning.

Result<bool> MultipartReader::find_body_end(bool in_part) {
  const auto at = pending_.find(delimiter_);
  const bool found = at != std::string::npos;
  // What cannot be the beginning of a delimiter goes on.
  const std::size_t kept = delimiter_.size() - 1;
  const std::size_t count = found ? at : pending_.size() - std::min(kept, pending_.size());
  if (in_part && count > 0) MOR_CHECK(sink_.data(std::string_view(pending_).substr(0, count)));
  pending_.erase(0, found ? at + delimiter_.size() : count);
  if (!found) return false;
  if (in_part) MOR_CHECK(sink_.end());
  state_ = State::kDelimiter;
  return true;
}

Result<bool> MultipartReader::pass_delimiter() {
  if (pending_.size() < 2) return false;
  if (pending_.starts_with("--")) {
    state_ = State::kEpilogue;
    return true;
  }
  const auto end = pending_.find(kLineEnd);
  if (end == std::string::npos) {
    if (pending_.size() > kMaxBoundaryBytes) return broken("its boundary has no end of line");
    return false;
  }
  if (pending_.find_first_not_of(" \t") != end) return broken("its boundary goes on");
  pending_.erase(0, end);  // The line's end may be all of the head.
  state_ = State::kHead;
  return true;
}

Result<bool> MultipartReader::pass_head() {
  const auto end = pending_.find(kHeadEnd);
  if (end == std::string::npos || end > kMaxHeadBytes) {
    if (pending_.size() > kMaxHeadBytes) return broken("the head of a part has no end");
    return false;
  }
  pending_.erase(0, end + kHeadEnd.size());
  MOR_CHECK(sink_.begin());
  state_ = State::kBody;
  return true;
}

Result<void> MultipartReader::feed(std::string_view bytes) {
  pending_ += bytes;
  for (bool goes_on = true; goes_on;) {
    switch (state_) {
      case State::kPreamble: {
        MOR_TRY(goes_on, find_body_end(false));
        break;
      }
      case State::kDelimiter: {
        MOR_TRY(goes_on, pass_delimiter());
        break;
      }
      case State::kHead: {
        MOR_TRY(goes_on, pass_head());
        break;
      }
      case State::kBody: {
        MOR_TRY(goes_on, find_body_end(true));
        break;
      }
      case State::kEpilogue:
        pending_.clear();
        goes_on = false;
    }
  }
  return {};
}

Result<void> MultipartReader::finish() const {
  if (state_ == State::kEpilogue) return {};
  return make_error(ErrorCode::kIo, "the answer ended too early");
}

}  // namespace mor::internal
