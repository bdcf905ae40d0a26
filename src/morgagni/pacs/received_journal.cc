// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/received_journal.h"

#include <system_error>

#include <nlohmann/json.hpp>

#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string text_of(const ReceivedObject& object) {
  const Json json = {{"uid", object.uid},
                     {"study_uid", object.study_uid},
                     {"series_uid", object.series_uid},
                     {"modality", object.modality},
                     {"patient_id", object.patient_id},
                     {"study_date", object.study_date},
                     {"series_number", object.series_number},
                     {"series_description", object.series_description}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

ReceivedObject object_of(const std::string& text, const fs::path& folder) {
  const auto json = Json::parse(text);
  ReceivedObject object{.uid = json.at("uid"),
                        .study_uid = json.at("study_uid"),
                        .series_uid = json.at("series_uid"),
                        .modality = json.at("modality"),
                        .patient_id = json.at("patient_id"),
                        .study_date = json.at("study_date"),
                        .series_number = json.at("series_number"),
                        .series_description = json.at("series_description")};
  object.file = folder / object.study_uid / object.series_uid / (object.uid + ".dcm");
  return object;
}

}  // namespace

ReceivedJournal::ReceivedJournal(const fs::path& folder)
    : receiver_folder_(folder), folder_(folder / "waiting") {}

Result<void> ReceivedJournal::add(const ReceivedObject& object) const {
  std::error_code status;
  fs::create_directories(folder_, status);
  return write_file(folder_ / (object.series_uid + ".json"), text_of(object));
}

void ReceivedJournal::remove(const std::string& series_uid) const {
  std::error_code status;
  fs::remove(folder_ / (series_uid + ".json"), status);
}

std::vector<ReceivedObject> ReceivedJournal::read() const {
  constexpr std::uintmax_t kMaxBytes = 65536;
  std::vector<ReceivedObject> all;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(folder_, status)) {
    const auto text = read_text_file(entry.path(), kMaxBytes);
    if (!text) continue;
    try {
      auto object = object_of(*text, receiver_folder_);
      if (is_dicom_uid(object.study_uid) && is_dicom_uid(object.series_uid))
        all.push_back(std::move(object));
    } catch (const Json::exception&) {
      continue;
    }
  }
  return all;
}

}  // namespace mor
