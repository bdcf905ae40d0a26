// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/device_id.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/printable_text.h"

namespace mor {
namespace {

constexpr std::size_t kMaxBytes = 100;

bool is_plain(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
         c == '_' || c == '.';
}

}  // namespace

Result<void> check_device_id(std::string_view id) {
  if (!id.empty() && id.size() <= kMaxBytes && id.front() != '.' &&
      std::ranges::all_of(id, is_plain)) {
    return {};
  }
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("'{}' is no device's id: letters, digits, '-', '_' and '.' alone, at most {}",
                  printable_text(std::string(id.substr(0, kMaxBytes))),
                  kMaxBytes));
}

std::string plain_device_id(std::string_view name) {
  std::string id(name.substr(0, kMaxBytes));
  std::ranges::replace_if(
      id, [](char c) { return !is_plain(c); }, '-');
  // Without the ends that say nothing.
  const auto first = id.find_first_not_of("-.");
  if (first == std::string::npos) return {};
  return id.substr(first, id.find_last_not_of("-.") + 1 - first);
}

}  // namespace mor
