// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/tag_values.h"

#include <algorithm>
#include <charconv>

namespace mor::internal {

std::string value_of(const TagValues& values, const char* name) {
  const auto found = values.find(name);
  return found == values.end() ? std::string() : found->second;
}

PacsStudy study_of(const TagValues& values) {
  return {.uid = value_of(values, tag::kStudyUid),
          .patient_id = value_of(values, tag::kPatientId),
          .patient_name = value_of(values, tag::kPatientName),
          .date = value_of(values, tag::kStudyDate),
          .description = value_of(values, tag::kStudyDescription),
          .accession = value_of(values, tag::kAccession),
          .modalities = value_of(values, tag::kModalitiesInStudy)};
}

PacsSeries series_of(const TagValues& values, const std::string& study_uid) {
  PacsSeries series{.study_uid = study_uid,
                    .uid = value_of(values, tag::kSeriesUid),
                    .modality = value_of(values, tag::kModality),
                    .number = value_of(values, tag::kSeriesNumber),
                    .description = value_of(values, tag::kSeriesDescription)};
  const auto count = value_of(values, tag::kNumSeriesInstances);
  std::from_chars(count.data(), count.data() + count.size(), series.num_instances);
  series.num_instances = std::clamp(series.num_instances, 0, kMaxInstances);
  return series;
}

TagValues keys_of(const PacsFilter& filter) {
  TagValues keys;
  const auto add = [&keys](const char* name, const std::string& value) {
    if (!value.empty()) keys[name] = value;
  };
  add(tag::kPatientName, filter.patient_name);
  add(tag::kPatientId, filter.patient_id);
  add(tag::kStudyDate, filter.study_date);
  add(tag::kModalitiesInStudy, filter.modality);
  add(tag::kAccession, filter.accession);
  add(tag::kStudyUid, filter.study_uid);
  return keys;
}

}  // namespace mor::internal
