// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "morgagni/pacs/storage_receiver.h"

namespace mor {

/// A series as it lies in FOLDER/STUDY/SERIES, with the words of its last object.
struct GatheredSeries {
  std::filesystem::path folder;
  ReceivedObject last;
  int num_objects = 0;  ///< That came since it was last handed out.

  /// CT slices; anything else is not what a case is made of.
  [[nodiscard]] bool is_ct() const { return last.modality == "CT"; }

  /// A name for its case, the same each time: patient, date and number of the series, and letters
  /// made of its UID, so that no two series share one. Harmless as a file's name.
  [[nodiscard]] std::string case_name() const;
};

/// Collects what arrives by study and says when a study has been quiet for so long that it is
/// likely complete. DICOM has no sign for "that was all". One thread at a time.
class StudyGatherer {
 public:
  using Clock = std::chrono::steady_clock;

  explicit StudyGatherer(std::chrono::seconds quiet) : quiet_(quiet) {}

  /// @return Whether it is the first of its series since that was handed out.
  bool add(const ReceivedObject& object, Clock::time_point now);

  /// The series of a study that has been quiet, in the order of their numbers, and forgets them;
  /// empty: none yet.
  [[nodiscard]] std::vector<GatheredSeries> take_quiet(Clock::time_point now);

  /// Whether something of that series came and was not handed out yet.
  [[nodiscard]] bool has(const std::string& study_uid, const std::string& series_uid) const;

  /// When the next study may be quiet; none: there is none.
  [[nodiscard]] std::optional<Clock::time_point> next_due() const;

 private:
  struct Study {
    Clock::time_point last_at;
    std::map<std::string, GatheredSeries> series;
  };

  std::chrono::seconds quiet_;
  std::map<std::string, Study> studies_;
};

}  // namespace mor
