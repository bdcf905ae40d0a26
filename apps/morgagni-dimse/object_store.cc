// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "object_store.h"

#include <filesystem>
#include <system_error>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/pacs/dimse_protocol.h"

#include "dataset_tags.h"
#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmdata/dctk.h"
#include "messages.h"

namespace mor::dimse {
namespace {

namespace fs = std::filesystem;

/// Values beyond this stay on disk: the head only is wanted.
constexpr Uint32 kMaxValueBytes = 1024;

/// What the parent sorts by and shows.
Result<Tags> head_of(const std::string& file) {
  DcmFileFormat format;
  const auto status = format.loadFileUntilTag(
      file.c_str(), EXS_Unknown, EGL_noChange, kMaxValueBytes, ERM_fileOnly, DCM_PixelData);
  if (status.bad())
    return make_error(ErrorCode::kInvalidArgument, fmt::format("no DICOM: {}", status.text()));
  auto& dataset = *format.getDataset();
  (void)dataset.convertToUTF8();
  return tags_of(dataset,
                 {DCM_StudyInstanceUID,
                  DCM_SeriesInstanceUID,
                  DCM_Modality,
                  DCM_PatientID,
                  DCM_PatientName,
                  DCM_StudyDate,
                  DCM_SeriesNumber,
                  DCM_SeriesDescription});
}

}  // namespace

bool is_uid(const std::string& text) {
  return !text.empty() && text.size() <= 64 && text.front() != '.' && text.back() != '.' &&
         text.find("..") == std::string::npos &&
         text.find_first_not_of("0123456789.") == std::string::npos;
}

ObjectStore::ObjectStore(const Task& task)
    : folder_(task.folder),
      parts_(task.parts),
      min_free_bytes_(task.min_free_bytes),
      sorts_(task.name == kReceive) {}

Result<void> ObjectStore::check_room() const {
  std::error_code status;
  const auto space = fs::space(folder_, status);
  if (!status && space.available >= min_free_bytes_) return {};
  return make_error(
      ErrorCode::kIo,
      status ? fmt::format("{}: {}", folder_, status.message())
             : fmt::format("{}: {} MB of disk are left, {} MB are kept free (--min-free-mb)",
                           folder_,
                           space.available / 1000000,
                           min_free_bytes_ / 1000000));
}

std::string ObjectStore::part_file() {
  return fmt::format("{}/{}-{}.part", parts_, ::getpid(), ++num_parts_);
}

Result<void> ObjectStore::keep(const std::string& part, const std::string& sop_instance_uid) {
  if (!is_uid(sop_instance_uid))
    return make_error(ErrorCode::kInvalidArgument, "an object without a proper SOP Instance UID");
  fs::path folder = folder_;
  Tags tags;
  std::error_code status;
  if (sorts_) {
    MOR_TRY(tags, head_of(part));
    const auto& study = tags["0020000D"];
    const auto& series = tags["0020000E"];
    if (!is_uid(study) || !is_uid(series)) {
      return make_error(ErrorCode::kInvalidArgument,
                        sop_instance_uid + " does not say of which study and series it is");
    }
    folder = folder / study / series;
    fs::create_directories(folder, status);
  }
  const auto file = folder / (sop_instance_uid + ".dcm");
  if (!status) fs::rename(part, file, status);
  if (status) return make_error(ErrorCode::kIo, file.string() + ": " + status.message());
  tags["00080018"] = sop_instance_uid;
  say_stored(file.string(), fs::file_size(file, status), tags);
  return {};
}

void ObjectStore::discard(const std::string& part) const {
  std::error_code status;
  fs::remove(part, status);
}

}  // namespace mor::dimse
