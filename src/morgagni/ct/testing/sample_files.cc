// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/testing/sample_files.h"

#include <stdexcept>

#include "morgagni/ct/testing/sample_parts.h"

namespace mor::testing_files {

std::vector<SampleFile> sample_files(std::string_view format) {
  if (format == "dicom") return dicom_samples();
  if (format == "rtstruct") return structure_set_samples();
  if (format == "nifti") return nifti_samples();
  if (format == "nrrd") return nrrd_samples();
  if (format == "mha") return meta_samples();
  if (format == "ply") return ply_samples();
  if (format == "stl") return stl_samples();
  if (format == "obj") return obj_samples();
  if (format == "vtp") return vtp_samples();
  throw std::invalid_argument("no samples of " + std::string(format));
}

}  // namespace mor::testing_files
