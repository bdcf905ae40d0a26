// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/study_gatherer.h"

#include <algorithm>
#include <charconv>
#include <span>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

/// Letters, digits and dashes of a stranger's text.
std::string plain(const std::string& text, std::size_t max_letters) {
  std::string letters;
  for (const char letter : text) {
    const bool kept = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                      (letter >= '0' && letter <= '9');
    if (kept) letters += letter;
    if (!kept && !letters.empty() && letters.back() != '-') letters += '-';
    if (letters.size() == max_letters) break;
  }
  while (!letters.empty() && letters.back() == '-') letters.pop_back();
  return letters;
}

int number_of(const std::string& text) {
  int number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace

std::string GatheredSeries::case_name() const {
  constexpr std::size_t kIdLetters = 24;
  constexpr std::size_t kHashLetters = 8;
  const auto patient = plain(last.patient_id, kIdLetters);
  const auto date = plain(last.study_date, 8);
  const auto hash = sha256_hex(std::as_bytes(std::span(last.series_uid))).substr(0, kHashLetters);
  return fmt::format("{}{}_series{}_{}",
                     patient.empty() ? "unknown" : patient,
                     date.empty() ? "" : "_" + date,
                     std::clamp(number_of(last.series_number), 0, 99999),
                     hash);
}

bool StudyGatherer::add(const ReceivedObject& object, Clock::time_point now) {
  auto& study = studies_[object.study_uid];
  study.last_at = now;
  auto& series = study.series[object.series_uid];
  series.folder = object.file.parent_path();
  series.last = object;
  return ++series.num_objects == 1;
}

std::vector<GatheredSeries> StudyGatherer::take_quiet(Clock::time_point now) {
  const auto quiet = std::find_if(studies_.begin(), studies_.end(), [&](const auto& entry) {
    return now - entry.second.last_at >= quiet_;
  });
  std::vector<GatheredSeries> all;
  if (quiet == studies_.end()) return all;
  for (auto& [uid, series] : quiet->second.series) all.push_back(std::move(series));
  studies_.erase(quiet);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return number_of(a.last.series_number) < number_of(b.last.series_number);
  });
  return all;
}

bool StudyGatherer::has(const std::string& study_uid, const std::string& series_uid) const {
  const auto study = studies_.find(study_uid);
  return study != studies_.end() && study->second.series.count(series_uid) != 0;
}

std::optional<StudyGatherer::Clock::time_point> StudyGatherer::next_due() const {
  std::optional<Clock::time_point> due;
  for (const auto& [uid, study] : studies_) {
    const auto at = study.last_at + quiet_;
    if (!due || at < *due) due = at;
  }
  return due;
}

}  // namespace mor
