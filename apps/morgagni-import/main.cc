// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Reads a CT that nobody vouches for and hands it to the process that started it. See
// morgagni/ct/import_protocol.h.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>

#include <sys/stat.h>

#include "dicom_segmentation.h"
#include "dicom_study.h"
#include "image_file.h"
#include "mesh_file.h"
#include "messages.h"
#include "sandbox.h"
#include "study_files.h"

namespace {

using mor::Result;
namespace fs = std::filesystem;

struct Job {
  std::string_view task;
  fs::path path;
  std::string series;
};

Result<void> work(const Job& job) {
  if (job.task == mor::kReadMeshTask) return mor::import::import_mesh_file(job.path);
  const bool is_study = fs::is_directory(job.path) || mor::import::is_study_file(job.path);
  if (job.task == mor::kReadLabelsTask) {
    return is_study ? mor::import::import_dicom_segmentation(job.path)
                    : mor::import::import_label_file(job.path);
  }
  if (job.task == mor::kListSeriesTask) {
    if (is_study) return mor::import::list_dicom_series(job.path);
    return mor::make_error(mor::ErrorCode::kUnsupported,
                           job.path.string() + " is no DICOM folder or file: it has no series");
  }
  if (is_study) return mor::import::import_dicom(job.path, job.series);
  if (job.series.empty()) return mor::import::import_image_file(job.path);
  return mor::make_error(mor::ErrorCode::kInvalidArgument,
                         job.path.string() +
                             " is no DICOM folder or file: it has no series to "
                             "choose from");
}

Result<void> work_safely(const Job& job) {
  try {
    return work(job);
  } catch (const std::bad_alloc&) {
    return mor::make_error(mor::ErrorCode::kIo,
                           job.path.string() +
                               " asks for more memory than an import may use: it is "
                               "damaged or too large");
  } catch (const std::exception& failure) {
    return mor::make_error(mor::ErrorCode::kIo,
                           job.path.string() + " cannot be read: " + failure.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  struct stat info {};
  if (argc != 4 || ::fstat(mor::kImportVoxelsFd, &info) != 0) {
    std::fputs("morgagni-import is started by morgagni, it is of no use alone.\n", stderr);
    return 2;
  }
  mor::import::give_up_rights();
  if (const auto done = work_safely({argv[1], argv[2], argv[3]}); !done) {
    mor::import::say_error(done.error());
    return 1;
  }
  return 0;
}
