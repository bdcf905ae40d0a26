// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/key_values.h"

#include <charconv>
#include <cmath>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "morgagni/camera/device_id.h"

namespace mor::internal {
namespace {

template <class T>
bool parse_whole(std::string_view text, T& value) {
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc() && end == text.data() + text.size();
}

template <class T>
tl::unexpected<Error> out_of_range(const KeyValue& pair, T least, T most) {
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("{} must be in [{}, {}], got '{}'", pair.key, least, most, pair.value));
}

}  // namespace

Result<std::vector<KeyValue>> split_key_values(std::string_view text) {
  std::vector<KeyValue> pairs;
  while (!text.empty()) {
    const auto end = text.find(',');
    const auto part = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const auto equals = part.find('=');
    if (equals == std::string_view::npos) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("camera option '{}' must be written key=value", part));
    }
    pairs.push_back({part.substr(0, equals), part.substr(equals + 1)});
  }
  return pairs;
}

Result<std::uint64_t> parse_count(const KeyValue& pair, std::uint64_t least, std::uint64_t most) {
  std::uint64_t value = 0;
  if (parse_whole(pair.value, value) && value >= least && value <= most) return value;
  return out_of_range(pair, least, most);
}

Result<double> parse_number(const KeyValue& pair, double least, double most) {
  double value = 0.0;
  const bool is_number = parse_whole(pair.value, value) && std::isfinite(value);
  if (is_number && value >= least && value <= most) return value;
  return out_of_range(pair, least, most);
}

Result<std::size_t> parse_choice(const KeyValue& pair,
                                 const std::vector<std::string_view>& allowed) {
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    if (pair.value == allowed[i]) return i;
  }
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format(
          "{} must be one of {}, got '{}'", pair.key, fmt::join(allowed, ", "), pair.value));
}

Result<std::string> parse_device_id(const KeyValue& pair) {
  MOR_CHECK(check_device_id(pair.value));
  return std::string(pair.value);
}

tl::unexpected<Error> unknown_key(std::string_view camera,
                                  const KeyValue& pair,
                                  const std::vector<std::string_view>& allowed) {
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format(
          "the {} camera has no option '{}', only {}", camera, pair.key, fmt::join(allowed, ", ")));
}

}  // namespace mor::internal
