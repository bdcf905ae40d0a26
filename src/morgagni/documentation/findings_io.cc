// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/findings_io.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/documentation/internal/finding_json.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;
constexpr std::uintmax_t kMaxFileBytes = 256U << 20U;
constexpr int kMaxNumber = 999'999'999;
constexpr double kMaxCoordinateMm = 1e5;  ///< A hundred metres: no CT is larger.
constexpr std::array kKinds{std::pair{FindingKind::kPoint, std::string_view("point")},
                            std::pair{FindingKind::kDistance, std::string_view("distance")},
                            std::pair{FindingKind::kGeodesic, std::string_view("geodesic")}};

tl::unexpected<Error> refuse(std::string sentence) {
  return make_error(ErrorCode::kInvalidArgument, std::move(sentence));
}

tl::unexpected<Error> damaged(const fs::path& path, std::string_view what) {
  return refuse(fmt::format("{}: the findings are damaged ({})", path.string(), what));
}

// --- What a finding may be ---------------------------------------------------------------------

/// Bytes of the UTF-8 character that begins the text, by its first byte; 0: none begins so.
std::size_t utf8_length(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  return first >= 0xF0 && first < 0xF5 ? 4 : 0;
}

/// The first character, if the text begins with a proper one: no surrogate, not over-long.
std::optional<std::pair<char32_t, std::size_t>> first_character(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = utf8_length(first);
  if (length == 0 || length > text.size()) return std::nullopt;
  char32_t code = length == 1 ? first : first & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xC0U) != 0x80U) return std::nullopt;
    code = (code << 6U) | (byte & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kFirstOfLength{0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kFirstOfLength[length] || code > 0x10FFFF || is_surrogate) return std::nullopt;
  return std::pair(code, length);
}

bool is_control(char32_t code) {
  if (code == '\n' || code == '\t') return false;
  // Also the marks that turn the direction of writing: a note must read as it is stored.
  const bool turns = (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || turns;
}

bool is_place(const Eigen::Vector3d& p) {
  return p.allFinite() && p.cwiseAbs().maxCoeff() <= kMaxCoordinateMm;
}

bool is_length(const std::optional<double>& value) {
  return !value || (*value >= 0.0 && *value <= kMaxCoordinateMm);
}

bool is_plain_name(std::string_view name) {
  return name.size() <= 200 && !name.starts_with('.') &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_';
         });
}

Result<void> check_places(const Finding& finding) {
  const std::size_t num_wanted = finding.kind == FindingKind::kPoint ? 1 : 2;
  if (finding.points.size() != num_wanted) {
    return refuse(fmt::format("finding {}: a {} has {} point(s), got {}",
                              finding.id,
                              to_string(finding.kind),
                              num_wanted,
                              finding.points.size()));
  }
  const bool is_finite =
      std::all_of(finding.points.begin(), finding.points.end(), [](const FindingPoint& point) {
        return is_place(point.ct_mm) && is_length(point.bound_mm);
      });
  if (!is_finite || !std::all_of(finding.path_ct_mm.begin(), finding.path_ct_mm.end(), is_place)) {
    return refuse(fmt::format(
        "finding {}: coordinates must be numbers within {} mm", finding.id, kMaxCoordinateMm));
  }
  if (finding.path_ct_mm.size() > kMaxPathPoints) {
    return refuse(fmt::format("finding {}: its way has {} points, the limit is {}",
                              finding.id,
                              finding.path_ct_mm.size(),
                              kMaxPathPoints));
  }
  return {};
}

// --- JSON --------------------------------------------------------------------------------------

bool is_number_or_null(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found == json.end() || found->is_null() || found->is_number();
}

std::optional<double> optional_number(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<std::string> text_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

std::optional<Eigen::Vector3d> place_of(const Json& json) {
  if (!json.is_array() || json.size() != 3) return std::nullopt;
  Eigen::Vector3d p;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!json[i].is_number()) return std::nullopt;
    p[static_cast<Eigen::Index>(i)] = json[i].get<double>();
  }
  return p;
}

std::optional<FindingPoint> point_of(const Json& json) {
  if (!json.is_object() || !json.contains("ct_mm") || !is_number_or_null(json, "bound_mm"))
    return std::nullopt;
  const auto place = place_of(json["ct_mm"]);
  const auto on_skin = json.find("on_skin");
  if (!place || on_skin == json.end() || !on_skin->is_boolean()) return std::nullopt;
  return FindingPoint{.ct_mm = *place,
                      .is_on_skin = on_skin->get<bool>(),
                      .bound_mm = optional_number(json, "bound_mm")};
}

std::optional<Finding> finding_of(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  const auto id = text_of(json, "id");
  const auto kind = parse_finding_kind(text_of(json, "kind").value_or(""));
  const auto note = text_of(json, "note");
  const auto points = json.find("points");
  if (!id || !kind || !note || points == json.end() || !points->is_array() ||
      !is_number_or_null(json, "length_mm") || !is_number_or_null(json, "length_bound_mm"))
    return std::nullopt;
  Finding finding{.id = *id,
                  .kind = *kind,
                  .note = *note,
                  .points = {},
                  .path_ct_mm = {},
                  .length_mm = optional_number(json, "length_mm"),
                  .length_bound_mm = optional_number(json, "length_bound_mm"),
                  .created_at = text_of(json, "created_at").value_or(""),
                  .photo = text_of(json, "photo").value_or("")};
  for (const auto& item : *points) {
    const auto point = point_of(item);
    if (!point) return std::nullopt;
    finding.points.push_back(*point);
  }
  for (const auto& item : json.value("path_ct_mm", Json::array())) {
    const auto place = place_of(item);
    if (!place) return std::nullopt;
    finding.path_ct_mm.push_back(*place);
  }
  return finding;
}

struct Contents {
  std::vector<Finding> findings;
  int last_number = 0;
};

int largest_number(const std::vector<Finding>& findings) {
  int largest = 0;
  for (const auto& finding : findings)
    largest = std::max(largest, finding_number(finding.id).value_or(0));
  return largest;
}

Result<void> check_all(const std::vector<Finding>& findings) {
  if (findings.size() > kMaxFindings) {
    return refuse(
        fmt::format("a case takes up to {} findings, there are {}", kMaxFindings, findings.size()));
  }
  std::set<std::string> ids;
  for (const auto& finding : findings) {
    MOR_CHECK(check_finding(finding));
    if (!ids.insert(finding.id).second)
      return refuse(fmt::format("there are two findings {}", finding.id));
  }
  return {};
}

Result<Contents> read_contents(const fs::path& folder) {
  const fs::path path = folder / kFindingsFile;
  if (std::error_code status; !fs::exists(path, status)) return Contents{};
  MOR_TRY(const auto text, read_text_file(path, kMaxFileBytes));
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return damaged(path, "no JSON");
  const auto format = json.find("format");
  if (format == json.end() || !format->is_number_integer()) return damaged(path, "no format");
  if (*format != kFormat) {
    return make_error(ErrorCode::kUnsupported,
                      fmt::format("{}: the findings have format {}, this program reads {}: use "
                                  "a newer Morgagni",
                                  path.string(),
                                  format->dump(),
                                  kFormat));
  }
  const auto list = json.find("findings");
  if (list == json.end() || !list->is_array()) return damaged(path, "no list");
  Contents contents;
  for (const auto& item : *list) {
    auto finding = finding_of(item);
    if (!finding) return damaged(path, fmt::format("entry {}", contents.findings.size() + 1));
    contents.findings.push_back(*std::move(finding));
  }
  if (const auto checked = check_all(contents.findings); !checked)
    return damaged(path, checked.error().message);
  const auto last = json.find("last_number");
  if (last != json.end() && last->is_number_integer() && *last >= 0 && *last <= kMaxNumber)
    contents.last_number = last->get<int>();
  contents.last_number = std::max(contents.last_number, largest_number(contents.findings));
  return contents;
}

}  // namespace

std::string_view to_string(FindingKind kind) {
  return std::find_if(
             kKinds.begin(), kKinds.end(), [kind](const auto& each) { return each.first == kind; })
      ->second;
}

std::optional<FindingKind> parse_finding_kind(std::string_view text) {
  const auto found = std::find_if(
      kKinds.begin(), kKinds.end(), [text](const auto& each) { return each.second == text; });
  if (found == kKinds.end()) return std::nullopt;
  return found->first;
}

Result<void> check_note(std::string_view note) {
  if (note.size() > kMaxNoteBytes) {
    return refuse(
        fmt::format("a note takes up to {} bytes, this one has {}", kMaxNoteBytes, note.size()));
  }
  while (!note.empty()) {
    const auto character = first_character(note);
    if (!character) return refuse("the note is no UTF-8 text");
    if (is_control(character->first)) {
      return refuse(
          fmt::format("the note has a control character (U+{:04X}): only line breaks "
                      "and tabs are taken",
                      static_cast<unsigned>(character->first)));
    }
    note.remove_prefix(character->second);
  }
  return {};
}

Result<void> check_finding(const Finding& finding) {
  if (!finding_number(finding.id))
    return refuse("a finding's id is F and a number from 1 to 999999999");
  if (const auto note = check_note(finding.note); !note)
    return refuse(fmt::format("finding {}: {}", finding.id, note.error().message));
  MOR_CHECK(check_places(finding));
  if (!is_length(finding.length_mm) || !is_length(finding.length_bound_mm))
    return refuse(fmt::format(
        "finding {}: lengths must be numbers from 0 to {} mm", finding.id, kMaxCoordinateMm));
  if (!is_plain_name(finding.photo))
    return refuse(fmt::format("finding {}: its photo's name is no plain file name", finding.id));
  if (finding.created_at.size() > 40 || !check_note(finding.created_at))
    return refuse(fmt::format("finding {}: its time is none", finding.id));
  return {};
}

std::optional<int> finding_number(std::string_view id) {
  if (!id.starts_with('F')) return std::nullopt;
  id.remove_prefix(1);
  int number = 0;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), number);
  const bool is_id = error == std::errc() && end == id.data() + id.size() && number >= 1 &&
                     number <= kMaxNumber && std::to_string(number) == id;
  return is_id ? std::optional(number) : std::nullopt;
}

Result<std::vector<Finding>> read_findings(const fs::path& folder) {
  MOR_TRY(auto contents, read_contents(folder));
  return std::move(contents.findings);
}

Result<int> last_finding_number(const fs::path& folder) {
  MOR_TRY(const auto contents, read_contents(folder));
  return contents.last_number;
}

Result<void> write_findings(const fs::path& folder, const std::vector<Finding>& findings) {
  MOR_CHECK(check_all(findings));
  MOR_TRY(const Contents before, read_contents(folder));
  std::error_code status;
  fs::create_directories(folder, status);
  if (status) {
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: cannot be made: {}", folder.string(), status.message()));
  }
  Json list = Json::array();
  for (const auto& finding : findings) list.push_back(internal::to_json(finding));
  const Json json = {{"format", kFormat},
                     {"frame", "ct (DICOM LPS), mm"},
                     {"last_number", std::max(before.last_number, largest_number(findings))},
                     {"findings", list}};
  return write_file(folder / kFindingsFile, json.dump(2) + "\n");
}

}  // namespace mor
