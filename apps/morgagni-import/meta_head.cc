// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string_view>
#include <system_error>

#include "head_checks.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

/// A MetaImage's lines "Key = Value" up to the one that names where the voxels are.
struct MetaHead {
  struct Line {
    std::string key;
    std::vector<std::string> words;
    std::string value;  ///< All of them, as they stand: a file's name may have blanks.
  };
  std::vector<Line> lines;
  std::uintmax_t num_bytes = 0;
  bool is_whole = false;

  [[nodiscard]] std::string first_word(std::string_view key) const {
    for (const auto& line : lines)
      if (line.key == key) return line.words.front();
    return {};
  }
  /// ElementDataFile, the last line of a whole head.
  [[nodiscard]] std::string data_file() const { return is_whole ? lines.back().value : ""; }
  [[nodiscard]] std::string repeated_key() const {
    std::set<std::string> keys;
    for (const auto& line : lines)
      if (!keys.insert(line.key).second) return line.key;
    return {};
  }
  [[nodiscard]] std::vector<std::int64_t> sides() const {
    std::vector<std::int64_t> sides;
    const auto line = std::find_if(
        lines.begin(), lines.end(), [](const Line& each) { return each.key == "DimSize"; });
    if (line == lines.end()) return sides;
    for (const auto& word : line->words) sides.push_back(std::strtoll(word.c_str(), nullptr, 10));
    return sides;
  }
};

std::string trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r";
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

MetaHead read_meta_head(const fs::path& path) {
  constexpr std::size_t kMostBytes = 1U << 16U;
  constexpr std::size_t kLongestLine = 499;  // Behind it MetaIO never ends,
  constexpr std::size_t kLongestKey = 254;   // and behind this it aborts.
  std::string text(kMostBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  MetaHead head;
  for (std::size_t start = 0; start < text.size();) {
    const auto end = std::min(text.find('\n', start), text.size());
    const std::string line = text.substr(start, end - start);
    start = end + 1;
    if (line.find('\0') != std::string::npos) return head;  // MetaIO reads a key up to there.
    if (words_of(line).empty()) continue;
    const auto separator = line.find_first_of("=:");
    const auto key = words_of(line.substr(0, separator));
    const auto words =
        words_of(separator == std::string::npos ? std::string() : line.substr(separator + 1));
    if (key.size() != 1 || words.empty() || line.size() > kLongestLine) return head;
    if (key.front().size() > kLongestKey) return head;
    head.lines.push_back({key.front(), words, trimmed(line.substr(separator + 1))});
    head.num_bytes = std::min(start, text.size());
    head.is_whole = key.front() == "ElementDataFile";
    if (head.is_whole) return head;
  }
  return head;
}

bool is_number(const std::string& word) {
  if (word.find_first_not_of("0123456789+-.eE") != std::string::npos) return false;
  char* end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  constexpr double kMost = 1e15;
  return *end == '\0' && std::abs(number) <= kMost;
}

/// How many numbers a key needs; none where it has no numbers.
std::size_t num_numbers(const std::string& key, std::size_t num_dimensions) {
  constexpr std::array<std::string_view, 9> kOne = {"NDims",
                                                    "ID",
                                                    "ParentID",
                                                    "HeaderSize",
                                                    "CompressedDataSize",
                                                    "ElementMin",
                                                    "ElementMax",
                                                    "ElementNumberOfChannels",
                                                    "ElementNBits"};
  constexpr std::array<std::string_view, 9> kVector = {"DimSize",
                                                       "Offset",
                                                       "Position",
                                                       "Origin",
                                                       "CenterOfRotation",
                                                       "ElementSpacing",
                                                       "ElementSize",
                                                       "ImagePosition",
                                                       "SequenceID"};
  constexpr std::array<std::string_view, 3> kMatrix = {
      "TransformMatrix", "Orientation", "Rotation"};
  const auto is_among = [&](const auto& keys) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  };
  if (is_among(kOne) || key.starts_with("ElementToIntensityFunction")) return 1;
  if (is_among(kVector)) return num_dimensions;
  if (is_among(kMatrix)) return num_dimensions * num_dimensions;
  return key == "Color" ? 4 : 0;
}

}  // namespace

Result<void> check_meta_head(const fs::path& path) {
  const std::string name = path.filename().string();
  const MetaHead head = read_meta_head(path);
  // Of two the readers here and MetaIO could each believe another one.
  if (const auto key = head.repeated_key(); !key.empty())
    return make_error(ErrorCode::kIo, name + " is damaged: its head says " + key + " twice");
  const long num_dimensions = std::strtol(head.first_word("NDims").c_str(), nullptr, 10);
  for (const auto& line : head.lines) {
    if (line.key == "NDims" && (num_dimensions < 1 || num_dimensions > 4))
      return refuse_dimensions(path, num_dimensions);
    const std::size_t needed = num_numbers(line.key, static_cast<std::size_t>(num_dimensions));
    const auto words = std::span(line.words).first(std::min(needed, line.words.size()));
    if (words.size() < needed || !std::all_of(words.begin(), words.end(), is_number)) {
      return make_error(ErrorCode::kIo,
                        name + " is damaged: behind its " + line.key + " stands no row of " +
                            std::to_string(needed) + " finite number(s)");
    }
  }
  if (!head.is_whole) {
    return make_error(ErrorCode::kIo,
                      name +
                          " is damaged or not what its name says: its head has no line that says "
                          "where the voxels are (ElementDataFile)");
  }
  // MetaIO writes past the end of its memory over some patterns, and divides by zero over others.
  if (head.data_file().starts_with("LIST") || head.data_file().find('%') != std::string::npos) {
    return make_error(ErrorCode::kUnsupported,
                      name + " keeps its voxels in several files: save it as one .mha");
  }
  return num_dimensions >= 3 ? check_sides(name, head.sides()) : Result<void>();
}

Result<void> check_meta_length(const fs::path& path, std::uintmax_t num_bytes) {
  const MetaHead head = read_meta_head(path);
  // MetaIO looks at the first letter alone.
  if (head.first_word("CompressedData").find_first_of("Tt1") == 0) {
    const std::string packed = head.first_word("CompressedDataSize");
    num_bytes = std::strtoull(packed.c_str(), nullptr, 10);
  }
  const std::string data_file = head.data_file();
  std::error_code failure;
  std::uintmax_t left = 0;
  if (data_file == "LOCAL") {
    left = fs::file_size(path, failure) - head.num_bytes;
  } else {
    left = fs::file_size(path.parent_path() / data_file, failure);
  }
  if (!failure && left >= num_bytes) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() + " is cut short: " + std::to_string(num_bytes) +
                        " bytes of voxels are announced, " + std::to_string(failure ? 0 : left) +
                        " are there");
}

}  // namespace mor::import
