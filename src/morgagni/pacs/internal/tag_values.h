// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "morgagni/pacs/pacs_peer.h"

namespace mor::internal {

/// Of one object that a peer found: tag ("0020000D") -> text, several values with backslashes.
using TagValues = std::map<std::string, std::string>;

namespace tag {
inline constexpr const char* kSopInstanceUid = "00080018";
inline constexpr const char* kStudyDate = "00080020";
inline constexpr const char* kAccession = "00080050";
inline constexpr const char* kModality = "00080060";
inline constexpr const char* kModalitiesInStudy = "00080061";
inline constexpr const char* kStudyDescription = "00081030";
inline constexpr const char* kSeriesDescription = "0008103E";
inline constexpr const char* kPatientName = "00100010";
inline constexpr const char* kPatientId = "00100020";
inline constexpr const char* kStudyUid = "0020000D";
inline constexpr const char* kSeriesUid = "0020000E";
inline constexpr const char* kSeriesNumber = "00200011";
inline constexpr const char* kNumSeriesInstances = "00201209";
}  // namespace tag

/// Empty where it is not there.
[[nodiscard]] std::string value_of(const TagValues& values, const char* name);

[[nodiscard]] PacsStudy study_of(const TagValues& values);
[[nodiscard]] PacsSeries series_of(const TagValues& values, const std::string& study_uid);

/// What of a study the filter asks for, as keys of a query.
[[nodiscard]] TagValues keys_of(const PacsFilter& filter);

}  // namespace mor::internal
