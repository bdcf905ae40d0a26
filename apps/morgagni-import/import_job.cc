// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "import_job.h"

#include <exception>
#include <new>

#include "morgagni/ct/import_protocol.h"

#include "dicom_segmentation.h"
#include "dicom_structures.h"
#include "dicom_study.h"
#include "image_file.h"
#include "mesh_file.h"
#include "study_files.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

Result<void> work(const ImportJob& job) {
  if (job.task == kTryLimitsTask) return {};
  if (job.task == kReadMeshTask) return import_mesh_file(job.path);
  const bool is_study = fs::is_directory(job.path) || is_study_file(job.path);
  if (job.task == kReadLabelsTask) {
    if (!is_study) return import_label_file(job.path);
    return holds_structure_set(job.path) ? import_dicom_structures(job.path, job.series)
                                         : import_dicom_segmentation(job.path);
  }
  if (job.task == kListSeriesTask) {
    if (is_study) return list_dicom_series(job.path);
    return make_error(ErrorCode::kUnsupported,
                      job.path.string() + " is no DICOM folder or file: it has no series");
  }
  if (is_study) return import_dicom(job.path, job.series);
  if (job.series.empty()) return import_image_file(job.path);
  return make_error(ErrorCode::kInvalidArgument,
                    job.path.string() +
                        " is no DICOM folder or file: it has no series to "
                        "choose from");
}

}  // namespace

Result<void> do_job(const ImportJob& job) {
  try {
    return work(job);
  } catch (const std::bad_alloc&) {
    return make_error(ErrorCode::kIo,
                      job.path.string() +
                          " asks for more memory than an import may use: it is "
                          "damaged or too large");
  } catch (const std::exception& failure) {
    return make_error(ErrorCode::kIo, job.path.string() + " cannot be read: " + failure.what());
  }
}

}  // namespace mor::import
