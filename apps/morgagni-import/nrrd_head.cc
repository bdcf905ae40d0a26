// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <system_error>

#include "head_checks.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

/// A NRRD's lines "key: value" up to the empty one.
struct NrrdHead {
  std::map<std::string, std::string> fields;
  std::uintmax_t num_bytes = 0;  ///< With the empty line; 0: there is none.

  [[nodiscard]] std::string value(const std::string& key) const {
    const auto found = fields.find(key);
    return found == fields.end() ? std::string() : found->second;
  }
};

NrrdHead read_nrrd_head(const fs::path& path) {
  constexpr int kMaxLines = 5000;
  NrrdHead head;
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int i = 0; i < kMaxLines && std::getline(file, line); ++i) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) {
      head.num_bytes = static_cast<std::uintmax_t>(std::max<std::streamoff>(file.tellg(), 0));
      break;
    }
    const auto colon = line.find(": ");
    if (line.front() != '#' && colon != std::string::npos)
      head.fields.emplace(lower_case(line.substr(0, colon)), line.substr(colon + 2));
  }
  return head;
}

Result<void> refuse_nrrd(const fs::path& path, const std::string& why) {
  return make_error(ErrorCode::kIo, path.filename().string() + " is damaged: " + why);
}

Result<void> check_nrrd_sizes(const fs::path& path, const NrrdHead& head, long num_dimensions) {
  std::vector<std::int64_t> sides;
  for (const auto& word : words_of(head.value("sizes"))) {
    char* end = nullptr;
    sides.push_back(std::strtoll(word.c_str(), &end, 10));
    if (*end != '\0') {
      return refuse_nrrd(
          path, "one of its sizes is \"" + word.substr(0, 40) + "\", which is no whole number");
    }
  }
  if (sides.size() != static_cast<std::size_t>(num_dimensions)) {
    return refuse_nrrd(path,
                       "its head has " + std::to_string(sides.size()) + " sizes for " +
                           std::to_string(num_dimensions) + " dimensions");
  }
  return num_dimensions == 3 ? check_sides(path.filename().string(), sides) : Result<void>();
}

/// Teem reads beyond a list that its head holds.
Result<void> check_nrrd_data_file(const fs::path& path, const NrrdHead& head) {
  for (const char* key : {"data file", "datafile"}) {
    const std::string name = head.value(key);
    if (lower_case(name).starts_with("list") || name.find('%') != std::string::npos) {
      return make_error(
          ErrorCode::kUnsupported,
          path.filename().string() + " keeps its voxels in several files: save it as one .nrrd");
    }
  }
  return {};
}

}  // namespace

/// Teem ends the whole process over a NRRD of many dimensions, and reads "3c" as 3. A spacing that
/// is nan is one that nobody knows.
Result<void> check_nrrd_head(const fs::path& path) {
  const NrrdHead head = read_nrrd_head(path);
  if (head.fields.empty()) return {};  // No NRRD at all: its reader says so.
  for (const char* key : {"dimension", "sizes", "type", "encoding"})
    if (!head.fields.contains(key))
      return refuse_nrrd(path, std::string("its head has no line \"") + key + ":\"");
  const long num_dimensions = std::strtol(head.value("dimension").c_str(), nullptr, 10);
  if (num_dimensions < 2 || num_dimensions > 4) return refuse_dimensions(path, num_dimensions);
  MOR_CHECK(check_nrrd_sizes(path, head, num_dimensions));
  MOR_CHECK(check_nrrd_data_file(path, head));
  const auto spacings = words_of(head.value("spacings"));
  const auto is_unknown = [](const std::string& word) { return lower_case(word) == "nan"; };
  if (num_dimensions == 3 && std::any_of(spacings.begin(), spacings.end(), is_unknown)) {
    return make_error(ErrorCode::kInvalidArgument,
                      path.filename().string() + " says that its spacings are \"" +
                          head.value("spacings").substr(0, 80) +
                          "\": a body is measured in millimetres");
  }
  return {};
}

Result<void> check_nrrd_length(const fs::path& path, std::uintmax_t num_bytes) {
  const NrrdHead head = read_nrrd_head(path);
  const bool is_attached = !head.fields.contains("data file") && !head.fields.contains("datafile");
  if (head.value("encoding") != "raw" || !is_attached || head.num_bytes == 0) return {};
  std::error_code failure;
  const auto has = fs::file_size(path, failure) - head.num_bytes;
  if (!failure && has >= num_bytes) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() + " is cut short: " + std::to_string(num_bytes) +
                        " bytes of voxels are announced, " + std::to_string(has) + " are there");
}

}  // namespace mor::import
