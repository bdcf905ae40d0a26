// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/added_cts.h"

#include <algorithm>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/case.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNameBytes = 60;

bool is_letter_or_digit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
         static_cast<unsigned char>(c) >= 0x80;  // Of other alphabets, as UTF-8.
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= kMostNameBytes && is_letter_or_digit(name.front()) &&
         std::all_of(name.begin(),
                     name.end(),
                     [](char c) {
                       return is_letter_or_digit(c) ||
                              std::string_view(" -_.").find(c) != std::string_view::npos;
                     }) &&
         name.find(".part-") == std::string_view::npos;
}

/// Absolute, without "." and a slash at its end.
fs::path plain(const fs::path& folder) {
  return fs::absolute(folder / "").lexically_normal().parent_path();
}

}  // namespace

Result<fs::path> ct_folder(const fs::path& case_folder, const std::string& name) {
  if (name.empty()) return case_folder;
  if (is_name(name)) return case_folder / kAddedCtsFolder / name;
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format(
          "a CT's name has 1 to {} letters, digits, blanks, '-', '_' and '.', and begins with "
          "a letter or a digit; got \"{}\"",
          kMostNameBytes,
          name));
}

Result<fs::path> find_ct(const fs::path& case_folder, const std::string& name) {
  MOR_TRY(const auto folder, ct_folder(case_folder, name));
  std::error_code status;
  if (name.empty() || fs::exists(folder / kCaseFile, status)) return folder;
  const auto names = added_cts(case_folder);
  return make_error(
      ErrorCode::kNotFound,
      names.empty()
          ? fmt::format("{} has one CT only: add \"{}\" with `morgagni prepare CT --case {} --add "
                        "\"{}\"`",
                        case_folder.string(),
                        name,
                        case_folder.string(),
                        name)
          : fmt::format(
                "{} has no CT \"{}\", but {}", case_folder.string(), name, fmt::join(names, ", ")));
}

std::vector<std::string> added_cts(const fs::path& case_folder) {
  std::vector<std::string> names;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(case_folder / kAddedCtsFolder, status)) {
    const std::string name = entry.path().filename().string();
    if (is_name(name) && fs::exists(entry.path() / kCaseFile, status)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path case_of_added_ct(const fs::path& folder) {
  const fs::path ct = plain(folder);
  const fs::path case_folder = ct.parent_path().parent_path();
  std::error_code status;
  const bool is_added =
      ct.parent_path().filename() == kAddedCtsFolder && fs::exists(case_folder / kCaseFile, status);
  return is_added ? case_folder : fs::path();
}

std::string case_title(const fs::path& folder) {
  const fs::path case_folder = case_of_added_ct(folder);
  const std::string own = plain(folder).filename().string();
  return case_folder.empty() ? own : case_folder.filename().string() + ", " + own;
}

}  // namespace mor
