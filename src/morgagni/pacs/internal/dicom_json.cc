// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/dicom_json.h"

#include <nlohmann/json.hpp>

namespace mor::internal {
namespace {

using Json = nlohmann::json;

constexpr int kMaxDepth = 32;
constexpr std::size_t kMaxValues = 64;
constexpr std::size_t kMaxTextBytes = 1024;

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (value.is_number()) return value.dump();
  if (!value.is_object()) return {};
  const auto name = value.find("Alphabetic");
  return name != value.end() && name->is_string() ? name->get<std::string>() : std::string();
}

std::string text_of_all(const Json& element) {
  if (!element.is_object()) return {};
  const auto values = element.find("Value");
  if (values == element.end() || !values->is_array()) return {};
  std::string text;
  for (std::size_t i = 0; i < std::min(values->size(), kMaxValues); ++i) {
    if (i > 0) text += '\\';
    text += text_of((*values)[i]);
  }
  if (text.size() > kMaxTextBytes) text.resize(kMaxTextBytes);
  return text;
}

}  // namespace

Result<std::vector<TagValues>> parse_dicom_json(std::string_view text) {
  bool too_deep = false;
  const auto judge = [&too_deep](int depth, Json::parse_event_t /*event*/, Json& /*value*/) {
    too_deep = too_deep || depth > kMaxDepth;
    return !too_deep;
  };
  const auto json = Json::parse(text, judge, /*allow_exceptions=*/false);
  if (too_deep) return make_error(ErrorCode::kIo, "the answer is JSON nested more than 32 deep");
  if (!json.is_array()) return make_error(ErrorCode::kIo, "the answer is not a list in JSON");
  std::vector<TagValues> all;
  for (const auto& object : json) {
    if (!object.is_object())
      return make_error(ErrorCode::kIo, "the answer is not a list of objects in JSON");
    auto& values = all.emplace_back();
    for (const auto& [name, element] : object.items()) {
      constexpr std::size_t kTagLetters = 8;
      if (name.size() == kTagLetters) values[name] = text_of_all(element);
    }
  }
  return all;
}

}  // namespace mor::internal
