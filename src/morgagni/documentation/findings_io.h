// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/documentation/finding.h"

namespace mor {

/// The file that holds all findings of a case; photos lie beside it.
inline constexpr const char* kFindingsFile = "findings.json";

inline constexpr std::size_t kMaxFindings = 2000;
inline constexpr std::size_t kMaxNoteBytes = 4000;      ///< UTF-8.
inline constexpr std::size_t kMaxPathPoints = 100'000;  ///< Of one geodesic.

/// "point", "distance", "geodesic".
[[nodiscard]] std::string_view to_string(FindingKind kind);
[[nodiscard]] std::optional<FindingKind> parse_finding_kind(std::string_view text);

/// @errors kInvalidArgument: longer than kMaxNoteBytes, no UTF-8, control characters other than
/// line feed and tab.
[[nodiscard]] Result<void> check_note(std::string_view note);

/// @errors kInvalidArgument: which finding, what is wrong, which limit.
[[nodiscard]] Result<void> check_finding(const Finding& finding);

/// The number of "F12"; none where the text is no finding's id.
[[nodiscard]] std::optional<int> finding_number(std::string_view id);

/// The findings in `folder`. None where it has no findings.json.
/// @errors kIo; kInvalidArgument: damaged or of a newer format; says what.
[[nodiscard]] Result<std::vector<Finding>> read_findings(const std::filesystem::path& folder);

/// The largest number that a finding of `folder` ever had, deleted ones included; 0: none had one.
[[nodiscard]] Result<int> last_finding_number(const std::filesystem::path& folder);

/// Replaces the findings in `folder`, which is made where it is missing, in one step: a reader sees
/// the old list or the new one. Numbers of findings that are gone stay used.
/// @errors kInvalidArgument: a finding is not as check_finding() wants it, an id is there twice,
///         more than kMaxFindings, or the old file is damaged, which is then left alone; kIo.
[[nodiscard]] Result<void> write_findings(const std::filesystem::path& folder,
                                          const std::vector<Finding>& findings);

}  // namespace mor
